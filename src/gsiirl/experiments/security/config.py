"""The configuration of the security experiment, in which a defender lives with an attacker (docs/security.md)."""

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import Field
from pydantic.dataclasses import dataclass

from gsiirl.errors import InputError
from gsiirl.experiments.run_config import CHECKED, MANY, RunConfig

if TYPE_CHECKING:
    from gsiirl.scenarios import AttackNetwork


@dataclass(frozen=True, kw_only=True, config=CHECKED)
class SecurityConfig(RunConfig):
    """Everything that decides a run of the security experiment: its fields are flags, TOML keys and `config.json`."""

    experiment: ClassVar[str] = "security"
    preparation: ClassVar[str] = "gsiirl.experiments.security.run:prepare"
    double_precision: ClassVar[bool] = True

    graph: str | None = None
    """A NASim scenario's name, or a GraphML, JSON or NASim YAML file; without it a random graph is drawn from
    `graph_seed`."""
    graph_seed: int = Field(default=0, ge=0, le=2**31 - 1)
    """Seed of the random graph (not used with `graph`)."""
    nodes: int = Field(default=8, ge=2, le=16)
    """Nodes of the random graph."""
    edges: int = Field(default=10, ge=1, le=225)
    """Edges of the random graph."""
    variant: Literal["general_sum", "zero_sum"] = "general_sum"
    """`general_sum`: the defender's losses differ from the attacker's gains; `zero_sum`: the paper's, r_ld = -r_e."""
    learner_no_op: bool = False
    """Let the defender also block nothing, at no cost."""
    expert_no_op: bool = False
    """Let the attacker also attack nothing, at no cost."""
    expert: Literal["responding", "simulated"] = "responding"
    """`responding`: the expert plays its soft best response to the policy the learner plays; `simulated`: it is told
    what the learner acts on, and plays the equilibrium of that (the paper's)."""
    solver: Literal["logit", "soft_joint", "q_learning"] = "logit"
    """Forward model from rewards to a joint policy: `logit` equilibrium, `soft_joint` (the paper's eq. 5-7, both sides
    playing its marginals), or the paper's `q_learning`, which needs a hypergradient without derivatives."""
    commitment: Literal["policy", "reward"] | None = None
    """What the learner commits to: a `policy` (default), or a `reward` that it acts on through the forward model
    (paper)."""
    lower_level: Literal["likelihood", "matching", "equilibrium"] | None = None
    """How the expert's reward is fitted: by the conditional `likelihood`, to convergence (default; policy only); by
    `matching` features under the policy as played; or by matching under the `equilibrium` (paper; reward only)."""
    explore: Literal["informative", "thompson", "estimate"] | None = None
    """What is played while learning: the best policy under a draw of the posterior (`thompson`), the same after a first
    half of the most `informative` policies (default with the likelihood), or the best under the `estimate`. Policy
    only."""
    hand_back: Literal["average", "estimate"] | None = None
    """What is handed back: the best policy on `average` over the posterior (default with the likelihood), or under the
    `estimate`. Policy only."""
    starts: Literal["many", "one"] | None = None
    """Ascents in each iteration: from `many` policies (default), or from the `one` before. Policy only."""
    feedback: Literal["model", "visited"] | None = None
    """Where values of the dependent reward are read: everywhere by the `model` (default), or only along what was
    `visited`. Policy only."""
    response: Literal["well_specified", "frozen", "measured"] | None = None
    """What the hypergradient takes for the expert's response: `well_specified`, `frozen` (paper), or `measured`, from
    two more interactions an iteration. Commitment to a reward only."""
    hypergradient: Literal["implicit", "spsa", "hvp_cg", "finite_difference"] | None = None
    """Estimator of the hypergradient: `implicit`, `spsa` (paper). Commitment to a reward only."""
    schedule: Literal["adam", "paper"] | None = None
    """Steps of both levels: `adam`, or the `paper`'s plain steps, t_k = ceil((k+1)^(1/4)/2) inner ones and outer ones
    of 1/(smoothness sqrt(K)). Commitment to a reward only."""
    honest_start: bool | None = None
    """Step from the honest commitment, to the dependent reward fitted so far, where that is better (not in paper).
    Commitment to a reward only."""
    horizon: int = Field(default=10, ge=1, le=10_000)
    """Steps T of an episode."""
    temperature: Annotated[float, Field(gt=0)] | Literal["unknown"] | None = None
    """Temperature tau in reward units, shared by expert and forward model; default 0.4, on your own file 0.4 times its
    largest value or attack cost, and on NASim scenarios 0.05 times that. `unknown`: the expert has the default, and the
    learner is not told."""
    discount: float = Field(default=0.95, gt=0, le=1)
    """Discount gamma."""
    regularisation: float = Field(default=1e-3, gt=0)
    """Weight lambda of the lower level's squared norm."""
    reward_bound: float | None = Field(default=None, gt=0)
    """Bound on any one reward weight, all that is known of the rewards beforehand; default 1.5 on random graphs, else
    the largest value, loss or attack cost (1 on NASim's own scenarios)."""
    inner_steps: int = Field(default=10, ge=1, le=MANY)
    """Projected steps on the expert's parameters in each iteration (schedule `adam`)."""
    inner_step_size: float = Field(default=0.02, gt=0)
    """Step of the lower level: Adam's, in the unit ball, or the paper's on tau times the gradient."""
    step_size: float = Field(default=1.0, gt=0)
    """Adam's first step of the upper level, in units of temperature: rewards change by about this much times tau."""
    smoothness: float | None = Field(default=None, gt=0)
    """The paper's L_f, a bound on the curvature of f: its outer step is 1/(L_f sqrt(K)). Default 60, and 1.5 on NASim
    scenarios."""
    step_decay: float = Field(default=20.0, gt=0)
    """Iterations after which the upper level's step is halved: step_size / (1 + k / step_decay)."""
    remembered: int | None = Field(default=None, ge=1, le=MANY)
    """Interactions (policy played, demonstrations) that the lower level remembers, the newest always among them;
    default all with the likelihood, 16 with matching (paper 1)."""
    perturbation: float | None = Field(default=None, gt=0)
    """SPSA's first perturbation in the unit ball; default 0.05 (paper 1)."""
    perturbation_decay: float | None = Field(default=None, ge=0)
    """SPSA's perturbation falls as 1/(k+1) to this power; default 0.101 (paper 1)."""
    draws: int = Field(default=1, ge=1, le=10_000)
    """SPSA's directions in each iteration."""
    violation_weight: float = Field(default=1.0, ge=0)
    """What a deviation that pays costs the program of `lin2019`, for what one that loses gains it."""

    def resolved(self) -> Self:
        """The configuration with the values that a run uses where none were given.

        Raises:
            InputError: the hypergradient's estimator does not go with the solver or the lower level.
        """
        from gsiirl.scenarios import is_own_file
        from gsiirl.scenarios.random_graph import VALUE

        network = self.network()
        preset: dict[str, Any] = {
            "temperature": self.expert_temperature(network),
            "reward_bound": VALUE[1] if self.graph is None else network.largest_weight,
            "smoothness": 60.0 if self.graph is None or is_own_file(self.graph) else 1.5,
        }
        by_reward = self.algorithm == "paper" or self.expert == "simulated"
        if (self.commitment or ("reward" if by_reward else "policy")) == "policy":
            preset |= POLICY
            if self.lower_level == "matching":
                preset |= {"explore": "estimate", "hand_back": "estimate", "remembered": 16}
        else:
            preset |= PAPER if self.algorithm == "paper" else REWARD
            if self.solver == "q_learning":
                preset["hypergradient"] = "spsa"
        full = replace(self, **{name: value for name, value in preset.items() if getattr(self, name) is None})
        full._refuse_what_does_not_go_together()
        if full.solver == "q_learning" and full.hypergradient in ("implicit", "hvp_cg"):
            raise InputError(
                "hypergradient",
                f"{full.hypergradient} differentiates the solver, and q_learning cannot be differentiated",
                "use spsa or finite_difference",
            )
        if full.hypergradient == "hvp_cg" and full.response != "well_specified" and full.lower_level == "equilibrium":
            raise InputError(
                "hypergradient",
                "hvp_cg needs a symmetric Hessian, and the lower level equilibrium has none",
                "use implicit, finite_difference or spsa, or the lower level played",
            )
        return full

    def network(self) -> "AttackNetwork":
        """The attack network that is named.

        Raises:
            InputError: there is none.
        """
        from gsiirl.scenarios import load_network, random_network

        if self.graph is not None:
            return load_network(self.graph, self.variant)
        return random_network(self.graph_seed, self.nodes, self.edges, self.variant)

    def scales_of_file(self) -> str | None:
        """What a run takes for the scale of the rewards in a file, in words; None where there is no file.

        Raises:
            InputError: see `resolved`.
        """
        from gsiirl.scenarios import is_file

        if self.graph is None or not is_file(self.graph):
            return None
        network, full = self.network(), self.resolved()
        temperature = full.expert_temperature(network)
        given = self.temperature if isinstance(self.temperature, float) else None
        why = f" ({temperature / network.unit:g} x the largest value or attack cost)" if given is None else ""
        return f"{self.graph}: temperature {temperature:,.10g}{why}, bound of a reward weight {full.reward_bound:,.10g}"

    def expert_temperature(self, network: "AttackNetwork") -> float:
        """The expert's temperature on the network, whether or not the learner is told."""
        from gsiirl.scenarios import is_own_file

        if isinstance(self.temperature, float):
            return self.temperature
        if self.graph is None:
            return SOFT
        return network.unit * (SOFT if is_own_file(self.graph) else SHARP)

    def _refuse_what_does_not_go_together(self) -> None:
        if self.commitment == "reward":
            strange, mend = [name for name in ONLY_POLICY if getattr(self, name) is not None], "policy"
            if self.lower_level == "likelihood":
                strange.append("lower_level")
            if self.temperature == "unknown":
                raise InputError("temperature", "cannot be unknown to the paper's algorithm", "use --commitment policy")
        else:
            strange, mend = [name for name in ONLY_REWARD if getattr(self, name) is not None], "reward"
            if self.lower_level == "equilibrium":
                strange.append("lower_level")
            if self.expert == "simulated" and self.algorithm == "gsiirl":
                raise InputError(
                    "expert", "simulated is told the reward that the learner acts on", "use --commitment reward"
                )
            if self.lower_level == "matching" and (self.explore, self.hand_back) != ("estimate", "estimate"):
                raise InputError(
                    "lower_level", "matching has no posterior", "use explore estimate and hand_back estimate"
                )
        if strange and self.algorithm in ("gsiirl", "paper"):
            value = getattr(self, strange[0])
            raise InputError(
                strange[0], f"{value} does not go with a commitment to a {self.commitment}", f"use --commitment {mend}"
            )


SOFT, SHARP = 0.4, 0.05
"""Default temperatures, the sharp one on NASim's scenarios: in units of the largest value or attack cost of a file."""

POLICY: dict[str, Any] = {
    "commitment": "policy",
    "lower_level": "likelihood",
    "explore": "informative",
    "hand_back": "average",
    "starts": "many",
    "feedback": "model",
}
"""What `gsiirl` sets where nothing is given."""

ONLY_POLICY = ("explore", "hand_back", "starts", "feedback")
ONLY_REWARD = ("response", "hypergradient", "schedule", "honest_start", "perturbation", "perturbation_decay")

REWARD: dict[str, Any] = {
    "commitment": "reward",
    "lower_level": "matching",
    "response": "well_specified",
    "hypergradient": "implicit",
    "schedule": "adam",
    "honest_start": True,
    "remembered": 16,
    "perturbation": 0.05,
    "perturbation_decay": 0.101,
}
"""What `gsiirl` sets for a commitment to a reward."""

PAPER: dict[str, Any] = {
    "commitment": "reward",
    "lower_level": "equilibrium",
    "response": "frozen",
    "hypergradient": "spsa",
    "schedule": "paper",
    "honest_start": False,
    "remembered": 1,
    "perturbation": 1.0,
    "perturbation_decay": 1.0,
}
"""What `paper` sets where nothing is given."""
