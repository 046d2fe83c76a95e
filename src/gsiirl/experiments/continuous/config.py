"""What the configurations of the experiments with continuous states have in common."""

from typing import ClassVar, Literal, Self

from pydantic import Field
from pydantic.dataclasses import dataclass

from gsiirl.errors import InputError
from gsiirl.experiments.run_config import CHECKED, MANY, RunConfig


@dataclass(frozen=True, kw_only=True, config=CHECKED)
class ContinuousConfig(RunConfig):
    """Everything that decides a run: the fields are flags, TOML keys and `config.json`."""

    double_precision: ClassVar[bool] = False

    algorithm: Literal["gsiirl", "paper", "ma-irl", "marl"] = "gsiirl"
    """Which algorithm learns: `gsiirl` (our preset), `paper` (the same with the paper's settings), `ma-irl`; `marl` is
    given both true rewards."""
    solver: Literal["pathwise", "maddpg"] = "pathwise"
    """Forward model from rewards to a joint policy: `pathwise` (both sides ascend their returns by gradients through
    the dynamics), or the paper's `maddpg`, for `marl` only."""
    reward: Literal["linear", "network"] = "linear"
    """What the learned reward of the expert is made of: weights of fixed features, or a small network of them."""
    horizon: int = Field(default=25, ge=1, le=10_000)
    """Steps T of an episode."""
    discount: float = Field(default=0.95, gt=0, le=1)
    """Discount gamma."""
    regularisation: float = Field(default=1e-3, gt=0)
    """Weight lambda of the lower level's squared norm."""
    inner_steps: int = Field(default=20, ge=1, le=MANY)
    """Projected steps on the expert's parameters in each iteration (not in paper: t_k = ceil((k+1)^(1/4)/2))."""
    first_inner_steps: int = Field(default=300, ge=1, le=MANY)
    """As many in the first iteration, before the policies move."""
    inner_step_size: float = Field(default=0.03, gt=0)
    """First step of the lower level, in the unit ball; of `gsiirl` and `ma-irl`."""
    gradient_step_size: float = Field(default=0.01, gt=0)
    """Step of the lower level of `paper`, in units of the gap."""
    smoothness: float = Field(default=10.0, gt=0)
    """The paper's L_f: its outer step is 1/(L_f sqrt(K))."""
    remembered: int = Field(default=8, ge=1, le=MANY)
    """Interactions (policy played, demonstrations) that the lower level averages over: a uniform sample of all, with
    the newest always in it; `paper` has the newest alone."""
    compared: int = Field(default=25, ge=1, le=MANY)
    """Trajectories of each remembered interaction that a step of the lower level compares."""
    batch: int = Field(default=64, ge=1, le=MANY)
    """Episodes of a gradient step of the solver."""
    learning_rate: float = Field(default=3e-3, gt=0)
    """Adam's first step on the policy networks; it falls to a tenth, and in training at once, as in settling, to a
    fiftieth."""
    noise: float = Field(default=0.0, ge=0)
    """Standard deviation of the noise on both sides' actions, before the outer tanh, while the solver learns."""
    expert_steps: int = Field(default=2, ge=1, le=MANY)
    """Steps that the solver's expert takes for each of the learner's."""
    solver_steps: int = Field(default=20, ge=1, le=MANY)
    """Solver steps in each outer iteration, from the policies of the last one."""
    response_steps: int = Field(default=100, ge=1, le=MANY)
    """Steps that the real expert takes towards its best response in each interaction, from its policies of the last."""
    model_response_steps: int = Field(default=25, ge=0, le=MANY)
    """Steps in each iteration that the modelled expert takes, from what the real one was seen to do, towards its best
    response to each remembered policy, before it is compared."""
    model_rate: float = Field(default=2e-3, gt=0)
    """Adam's first step on the modelled responses; it falls to a tenth."""
    cloning_steps: int = Field(default=300, ge=1, le=MANY)
    """Steps on the network that imitates the expert's demonstrations, in each interaction."""
    settling_steps: int = Field(default=0, ge=0, le=MANY)
    """Solver steps that the forward model takes after the last iteration, under the last rewards, before its policies
    are judged and kept; not of `marl` (not in paper)."""
    training_steps: int = Field(default=1000, ge=1, le=MANY)
    """Solver steps of `marl`, and of the pair that metrics call `truth`."""
    judging_steps: int = Field(default=1000, ge=1, le=MANY)
    """Steps of the best responses that final policies are judged by; the real expert takes a quarter of them before the
    first interaction."""
    maddpg_episodes: int = Field(default=800, ge=1, le=MANY)
    """Episodes of 100 environments that `marl` by MADDPG learns for, with an update after each of their steps."""
    hidden: int = Field(default=64, ge=1, le=4096)
    """Width of the policy networks' two hidden layers."""
    evaluation_episodes: int = Field(default=1000, ge=1, le=MANY)
    """Episodes over which reported returns and rates are means."""

    def resolved(self) -> Self:
        """The configuration itself, checked.

        Raises:
            InputError: the solver does not go with the algorithm.
        """
        if self.solver == "maddpg" and self.algorithm != "marl":
            raise InputError(
                "solver", f"maddpg does not go with algorithm {self.algorithm}", "use pathwise, or algorithm marl"
            )
        return self
