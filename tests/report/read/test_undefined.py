"""A correlation with a reward that is the same whatever happens is none."""

import numpy as np
import pytest

from gsiirl.report.read.undefined import undefined_correlations


@pytest.mark.parametrize("values", [[0.0, 0.0], [0.9, 0.0], [0.9, np.nan]])
def test_zero_and_no_number_are_no_correlation(values: list[float]) -> None:
    final = {
        "expert_reward_pearson": np.array(values),
        "expert_reward_epic": np.array([0.7, 0.7]),
        "dependent_reward_pearson": np.array([0.9, 0.8]),
        "regret": np.zeros(2),
    }
    assert undefined_correlations(final) == {"expert_reward_pearson", "expert_reward_epic"}


def test_all_other_correlations_are() -> None:
    assert undefined_correlations({"expert_reward_pearson": np.array([-0.3, 1e-9])}) == frozenset()
