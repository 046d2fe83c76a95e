"""The summary of a run: its final metrics over the seeds that did not fail."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import polars

from gsiirl.runs.files.numbers import is_sound
from gsiirl.runs.metrics import KEY_COLUMNS

GIVEN_THE_REWARDS = ("marl", "marl-maddpg")
"""Algorithms that learn no reward: they are given both."""


@dataclass(frozen=True)
class Statistics:
    """A metric over seeds."""

    mean: float
    std: float
    """With n - 1; 0 for one seed."""
    per_seed: list[float]

    @classmethod
    def of(cls, values: np.ndarray) -> "Statistics":
        """The statistics of values of shape [seeds], at least one."""
        std = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
        return cls(float(np.mean(values)), std, [float(value) for value in values])


@dataclass(frozen=True)
class Summary:
    """The content of `summary.json`.

    A seed has failed when one of its values is not finite, or when its deployed learner's return is below random
    play's (not asked of who is given the rewards).
    """

    experiment: str
    algorithm: str
    seeds: list[int]
    """In ascending order."""
    failed_seeds: list[int]
    iterations: int
    completed: bool
    final: dict[str, Statistics]
    """Of each metric, over the seeds that did not fail, in their order; empty when all failed."""
    files: list[str] = field(default_factory=list[str])
    """Names of the other files that the end of the run wrote; [] in a run of an earlier version."""

    def __post_init__(self) -> None:
        for name, seeds in (("seeds", self.seeds), ("failed_seeds", self.failed_seeds)):
            if seeds != sorted(set(seeds)) or not all(-(2**63) <= seed < 2**63 for seed in seeds):
                raise ValueError(f"{name} are not in ascending order")
        if not {*self.failed_seeds} <= {*self.seeds}:
            raise ValueError("failed_seeds names a seed that is none")
        if not 0 <= self.iterations < 2**63:
            raise ValueError(f"iterations cannot be {self.iterations}")
        for name, each in self.final.items():
            if len(each.per_seed) != len(self.kept_seeds) or not each.per_seed:
                raise ValueError(f"final.{name} holds {len(each.per_seed)} values of {len(self.kept_seeds)} seeds")

    @property
    def kept_seeds(self) -> list[int]:
        """Seeds that did not fail."""
        failed = {*self.failed_seeds}
        return [seed for seed in self.seeds if seed not in failed]


def summarise(config: dict[str, Any], metrics: polars.DataFrame, completed: bool) -> Summary:
    """The summary of a run, from each seed's last iteration."""
    last = last_iterations(metrics)
    names = [name for name in last.columns if name not in KEY_COLUMNS]
    failed = _failed(last, names, algorithm=config["algorithm"])
    kept = last.filter(~failed)
    return Summary(
        experiment=config["experiment"],
        algorithm=config["algorithm"],
        seeds=last["seed"].to_list(),
        failed_seeds=last.filter(failed)["seed"].to_list(),
        iterations=max(last["iteration"].to_list(), default=0),
        completed=completed,
        final={name: Statistics.of(kept[name].to_numpy()) for name in names} if len(kept) else {},
    )


def last_iterations(metrics: polars.DataFrame) -> polars.DataFrame:
    """The last row of every seed."""
    return metrics.group_by("seed", maintain_order=True).last().sort("seed")


def refuse_other_metrics(summary: Summary, metrics: polars.DataFrame) -> None:
    """See that a summary is one of these metrics.

    Raises:
        ValueError: it names other seeds, another iteration or other values.
    """
    last = last_iterations(metrics)
    if last["seed"].to_list() != summary.seeds or {*last["iteration"]} - {summary.iterations}:
        raise ValueError("it is not of the seeds and iterations of the metrics")
    kept = last.filter(polars.col("seed").is_in(summary.kept_seeds))
    for name, each in summary.final.items():
        if name not in kept.columns or kept[name].to_list() != each.per_seed:
            raise ValueError(f"final.{name} is not what the metrics say")


def _failed(last: polars.DataFrame, names: list[str], algorithm: str) -> polars.Series:
    failed = np.zeros(len(last), dtype=bool)
    for name in names:
        # A missing value counts as not finite.
        failed |= ~is_sound(last[name].cast(polars.Float64).fill_null(np.nan).to_numpy())
    returns = ("deployed_return_learner", "random_return_learner")
    if algorithm not in GIVEN_THE_REWARDS and set(returns) <= set(names):
        deployed, random = (last[name].to_numpy() for name in returns)
        failed |= deployed < random
    return polars.Series(failed)
