"""What is known of the expert's weights when a run ends: draws from their posterior, and an interval for each."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Array

from gsiirl.front_door.learned_reward import interval_of
from gsiirl.runs.learned import DETERMINED, Interval
from gsiirl.runs.policies import DRAWS

LEVEL = 0.9


def intervals_of(
    policies: Mapping[str, Array], record: Mapping[str, Array], scale: float
) -> dict[str, list[Interval | None]]:
    """Intervals at `LEVEL` of every seed's weights of r_e, in reward units; empty where no draws were kept.

    `policies` and `record` are what the runs of all seeds end with, `scale` the reward units of a weight of 1.
    """
    if DRAWS not in policies:
        return {}
    draws, priors = np.asarray(policies[DRAWS]), np.asarray(record["prior_deviation"])
    return {
        "expert_reward": [_interval(scale * each, scale * prior) for each, prior in zip(draws, priors, strict=True)]
    }


def _interval(draws: np.ndarray, prior: float) -> Interval | None:
    if not np.isfinite(draws).all():
        return None
    low, high = interval_of(draws, LEVEL)
    determined = draws.std(axis=0, ddof=1) <= DETERMINED * prior
    return Interval(LEVEL, low.tolist(), high.tolist(), determined.tolist())
