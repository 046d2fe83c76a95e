"""The summary of a run: its final metrics over the seeds that did not fail."""

from typing import Any

import numpy as np
import polars

from gsiirl.runs.files.json_file import versioned
from gsiirl.runs.metrics import KEY_COLUMNS

GIVEN_THE_REWARDS = ("marl", "marl-maddpg")
"""Algorithms that learn no reward: they are given both."""


def summarise(config: dict[str, Any], metrics: polars.DataFrame, completed: bool) -> dict[str, Any]:
    """The content of `summary.json`, from each seed's last iteration.

    A seed has failed when one of its values is not finite, or when its deployed learner's return is below random
    play's (not asked of who is given the rewards). `final` holds mean, standard deviation (n - 1; 0 for one seed) and
    the values of the seeds that did not fail, in the order of `seeds`; it is empty when all failed.
    """
    last = metrics.group_by("seed", maintain_order=True).last().sort("seed")
    names = [name for name in last.columns if name not in KEY_COLUMNS]
    failed = _failed(last, names, algorithm=config["algorithm"])
    kept = last.filter(~failed)
    return versioned(
        {
            "experiment": config["experiment"],
            "algorithm": config["algorithm"],
            "seeds": last["seed"].to_list(),
            "failed_seeds": last.filter(failed)["seed"].to_list(),
            "iterations": max(last["iteration"].to_list(), default=0),
            "completed": completed,
            "final": {name: statistics(kept[name].to_numpy()) for name in names} if len(kept) else {},
        }
    )


def _failed(last: polars.DataFrame, names: list[str], algorithm: str) -> polars.Series:
    failed = np.zeros(len(last), dtype=bool)
    for name in names:
        # A missing value counts as not finite.
        failed |= ~np.isfinite(last[name].cast(polars.Float64).fill_null(np.nan).to_numpy())
    returns = ("deployed_return_learner", "random_return_learner")
    if algorithm not in GIVEN_THE_REWARDS and set(returns) <= set(names):
        deployed, random = (last[name].to_numpy() for name in returns)
        failed |= deployed < random
    return polars.Series(failed)


def statistics(values: np.ndarray) -> dict[str, Any]:
    """Mean, standard deviation (n - 1; 0 for one seed) and the values themselves."""
    return {
        "mean": float(np.mean(values)),
        "std": float(np.std(values, ddof=1)) if len(values) > 1 else 0.0,
        "per_seed": [float(value) for value in values],
    }
