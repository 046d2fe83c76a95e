"""The configuration of the deception experiment: two agents keep an adversary from their target (MPE)."""

from typing import ClassVar, Literal

from pydantic.dataclasses import dataclass

from gsiirl.experiments.continuous import CHECKED, ContinuousConfig


@dataclass(frozen=True, kw_only=True, config=CHECKED)
class DeceptionConfig(ContinuousConfig):
    """Everything that decides a run of the deception experiment."""

    experiment: ClassVar[str] = "deception"
    preparation: ClassVar[str] = "gsiirl.experiments.deception_problem:prepare"

    variant: Literal["mpe", "separate_target"] = "mpe"
    """`mpe`: both sides want the same landmark, so that r_ld = -r_e; `separate_target`: the adversary wants another."""
