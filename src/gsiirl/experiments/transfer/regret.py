"""What policies of a changed game miss, beside the same procedure with the true rewards."""

from dataclasses import asdict
from typing import Any

import numpy as np

from gsiirl.runs import Statistics

TRUE, UNCHANGED, RANDOM = "true rewards", "policy unchanged", "random"
"""Rows that every changed game has: where regret is nothing, the policy of before, and where it is all of it."""


def rows(values: dict[str, np.ndarray]) -> dict[str, Any]:
    """Statistics over seeds of discounted and undiscounted returns [2, n], and of the regret to the true rewards.

    Where several searches were made with these, regret is to their mean.
    """
    best, random = float(values[TRUE][0].mean()), float(values[RANDOM][0].mean())
    span = best - random
    # Where nothing can be won there is nothing to miss.
    share = 100.0 / span if span > 1e-9 * max(1.0, abs(best)) else 0.0
    return {
        name: {
            "discounted_return": asdict(Statistics.of(each[0])),
            "return": asdict(Statistics.of(each[1])),
            "regret": asdict(Statistics.of(best - each[0])),
            "regret_percent": asdict(Statistics.of(share * (best - each[0]))),
        }
        for name, each in values.items()
    }


def over_changes(found: list[dict[str, Any]]) -> dict[str, Any]:
    """Of every row the regret in per cent, over all seeds and changes: mean, median, 90 % and the worst."""
    together: dict[str, list[float]] = {}
    for each in found:
        for name, row in each["rows"].items():
            together.setdefault(name, []).extend(row["regret_percent"]["per_seed"])
    return {
        name: {
            "mean": float(np.mean(regrets)),
            "median": float(np.median(regrets)),
            "ninety_percent": float(np.quantile(regrets, 0.9)),
            "worst": float(np.max(regrets)),
        }
        for name, regrets in together.items()
    }
