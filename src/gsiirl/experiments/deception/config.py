"""The configuration of the deception experiment: two agents keep an adversary from their target (MPE)."""

from typing import ClassVar, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.run_config import CHECKED, MANY


@dataclass(frozen=True, kw_only=True, config=CHECKED)
class DeceptionConfig(ContinuousConfig):
    """Everything that decides a run of the deception experiment."""

    experiment: ClassVar[str] = "deception"
    preparation: ClassVar[str] = "gsiirl.experiments.deception.problem:prepare"

    noise: float = Field(default=0.5, ge=0)
    """Standard deviation of the noise on both sides' actions, before the outer tanh, while the solver learns."""
    expert_steps: int = Field(default=1, ge=1, le=MANY)
    """Steps that the solver's expert takes for each of the learner's."""
    learning_rate: float = Field(default=5e-3, gt=0)
    """Adam's first step on the policy networks; it falls to a tenth, and in training at once, as in settling, to a
    fiftieth."""
    compared: int = Field(default=16, ge=1, le=MANY)
    """Trajectories of each remembered interaction that a step of the lower level compares."""
    model_rate: float = Field(default=5e-3, gt=0)
    """Adam's first step on the modelled responses; it falls to a tenth."""
    solver_steps: int = Field(default=100, ge=1, le=MANY)
    """Solver steps in each outer iteration, from the policies of the last one."""
    settling_steps: int = Field(default=10_000, ge=0, le=MANY)
    """Solver steps that the forward model takes after the last iteration, under the last rewards, before its policies
    are judged and kept; not of `marl` (not in paper)."""
    training_steps: int = Field(default=10_000, ge=1, le=MANY)
    """Solver steps of `marl`, and of the pair that metrics call `truth`."""
    judging_steps: int = Field(default=5000, ge=1, le=MANY)
    """Steps of the best responses that final policies are judged by; the real expert takes a quarter of them before the
    first interaction."""
    variant: Literal["mpe", "separate_target"] = "mpe"
    """`mpe`: both sides want the same landmark, so that r_ld = -r_e; `separate_target`: the adversary wants another."""
