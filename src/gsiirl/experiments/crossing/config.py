"""The configuration of the crossing experiment, in which a robot and a human cross each other's way."""

from typing import ClassVar

from pydantic import Field
from pydantic.dataclasses import dataclass

from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.run_config import CHECKED, MANY


@dataclass(frozen=True, kw_only=True, config=CHECKED)
class CrossingConfig(ContinuousConfig):
    """Everything that decides a run of the crossing experiment."""

    experiment: ClassVar[str] = "crossing"
    preparation: ClassVar[str] = "gsiirl.experiments.crossing.problem:prepare"

    iterations: int = Field(default=100, ge=0, le=MANY)
    """Outer iterations K."""
    horizon: int = Field(default=30, ge=1, le=10_000)
    """Steps T of an episode."""
    hidden: int = Field(default=32, ge=1, le=4096)
    """Width of the policy networks' two hidden layers."""
    inner_steps: int = Field(default=10, ge=1, le=MANY)
    """Projected steps on the expert's parameters in each iteration (not in paper: t_k = ceil((k+1)^(1/4)/2))."""
    solver_steps: int = Field(default=40, ge=1, le=MANY)
    """Solver steps in each outer iteration, from the policies of the last one."""
    training_steps: int = Field(default=2000, ge=1, le=MANY)
    """Solver steps of `marl`, and of the pair that metrics call `truth`."""
    judging_steps: int = Field(default=2000, ge=1, le=MANY)
    """Steps of the best responses that final policies are judged by; the real expert takes a quarter of them before the
    first interaction."""
