"""The configuration of the security experiment, in which a defender lives with an attacker (docs/security.md)."""

from dataclasses import replace
from pathlib import Path
from typing import Literal, Self

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

Algorithm = Literal["gsiirl", "ma-irl", "marl"]
Variant = Literal["general_sum", "zero_sum"]


@dataclass(
    frozen=True,
    kw_only=True,
    config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True),
)
class SecurityConfig:
    """Everything that decides a run of the security experiment: its fields are flags, TOML keys and `config.json`."""

    algorithm: Algorithm = "gsiirl"
    """Which algorithm learns; `marl` is given both true rewards."""
    graph: str | None = None
    """A NASim scenario's name, or a GraphML or JSON file; without it a random graph is drawn from `graph_seed`."""
    graph_seed: int = Field(default=0, ge=0)
    """Seed of the random graph (not used with `graph`)."""
    nodes: int = Field(default=8, ge=2, le=16)
    """Nodes of the random graph."""
    edges: int = Field(default=10, ge=1)
    """Edges of the random graph."""
    variant: Variant = "general_sum"
    """`general_sum`: the defender's losses differ from the attacker's gains; `zero_sum`: the paper's, r_ld = -r_e."""
    learner_no_op: bool = False
    """Let the defender also block nothing, at no cost."""
    expert_no_op: bool = False
    """Let the attacker also attack nothing, at no cost."""
    expert: Literal["responding"] = "responding"
    """`responding`: the expert plays its soft best response to the policy the learner plays."""
    solver: Literal["logit"] = "logit"
    """Forward model from rewards to a joint policy."""
    seeds: int = Field(default=10, ge=1)
    """Number of seeds."""
    first_seed: int = Field(default=0, ge=0)
    """The first seed; the others follow."""
    iterations: int = Field(default=50, ge=0)
    """Outer iterations K."""
    horizon: int = Field(default=10, ge=1)
    """Steps T of an episode."""
    temperature: float | None = Field(default=None, gt=0)
    """Temperature tau in reward units, shared by expert and forward model; default 0.4, and 0.05 on NASim
    scenarios, whose largest value is 1."""
    discount: float = Field(default=0.95, gt=0, le=1)
    """Discount gamma."""
    trajectories: int = Field(default=100, ge=1)
    """Trajectories asked of the expert in each interaction."""
    regularisation: float = Field(default=1e-3, gt=0)
    """Weight lambda of the lower level's squared norm."""
    reward_bound: float | None = Field(default=None, gt=0)
    """Bound on any one reward weight, all that is known of the rewards beforehand; default 1.5 on random graphs, 1 on
    NASim scenarios, and the largest value or loss in a file."""
    inner_steps: int = Field(default=10, ge=1)
    """Projected steps on the expert's parameters in each iteration."""
    inner_step_size: float = Field(default=0.02, gt=0)
    """Adam's step of the lower level, in the unit ball."""
    step_size: float = Field(default=1.0, gt=0)
    """Adam's first step of the upper level, in units of temperature: rewards change by about this much times tau."""
    step_decay: float = Field(default=20.0, gt=0)
    """Iterations after which the upper level's step is halved: step_size / (1 + k / step_decay)."""
    remembered: int = Field(default=16, ge=1)
    """Interactions (policy played, demonstrations) that the lower level averages over, the newest always among them."""
    device: Literal["cpu", "gpu"] = "cpu"
    """Where the arrays live."""

    def resolved(self) -> Self:
        """The configuration with the values that a run uses where none were given."""
        from gsiirl.scenarios import load_network
        from gsiirl.scenarios.random_graph import VALUE

        if self.graph is None:
            temperature, bound = 0.4, VALUE[1]
        elif Path(self.graph).is_file():
            network = load_network(self.graph, self.variant)
            largest = float(max(abs(network.value).max(), abs(network.criticality).max()))
            temperature, bound = 0.4, largest or 1.0
        else:
            temperature, bound = 0.05, 1.0
        return replace(
            self,
            temperature=temperature if self.temperature is None else self.temperature,
            reward_bound=bound if self.reward_bound is None else self.reward_bound,
        )
