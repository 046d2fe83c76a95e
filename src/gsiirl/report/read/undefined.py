"""Correlations that are not defined, since one of the two rewards is the same whatever happens."""

from collections.abc import Mapping

import numpy as np

CORRELATIONS = {
    "expert_reward_pearson": ("expert_reward_pearson", "expert_reward_epic", "expert_reward_starc"),
    "expert_reward_spearman": ("expert_reward_spearman",),
    "expert_reward_pearson_identified": (
        "expert_reward_pearson_identified",
        "expert_reward_epic_identified",
        "expert_reward_starc_identified",
    ),
    "expert_reward_pearson_played": ("expert_reward_pearson_played", "expert_reward_epic_played"),
    "dependent_reward_pearson": ("dependent_reward_pearson",),
}
"""By correlation: the metrics that are made of it."""


def undefined_correlations(final: Mapping[str, np.ndarray]) -> frozenset[str]:
    """Names of the final metrics that are no numbers: a run writes a correlation of exactly 0 where there is none."""
    undefined: set[str] = set()
    for correlation, metrics in CORRELATIONS.items():
        values = final.get(correlation)
        if values is not None and np.any((values == 0) | ~np.isfinite(values)):
            undefined.update(name for name in metrics if name in final)
    return frozenset(undefined)
