"""Intervals of a learned reward, and words for what the interactions did not determine."""

from typing import Any

import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.front_door.learned_reward import LearnedReward
from gsiirl.rewards.linear import TabularFeatures

NAMES = ("value of host 1", "value of host 2", "cost of edge a", "cost of edge b")
PRIOR = 2.0
TABLE = np.random.default_rng(0).normal(size=(2, 3, 2, 4))


def reward(deviations: tuple[float, ...], shared: float = 0.0, number: int = 4000) -> LearnedReward:
    """Independent weights of these deviations around 1, 2, 3, 4; `shared` is that of what both costs have in common."""
    random = np.random.default_rng(1)
    weights = np.arange(1.0, 5.0)
    draws = weights + np.asarray(deviations) * random.normal(size=(number, 4))
    draws[:, 2:] += shared * random.normal(size=(number, 1))
    return LearnedReward(NAMES, weights, TabularFeatures(table=TABLE, names=NAMES), draws, PRIOR)


def test_an_interval_of_weights_is_that_of_the_normal_law():
    found = reward((0.1, 0.2, 0.3, 0.4)).weight_intervals(0.9)
    assert found["name"].to_list() == list(NAMES)
    for place, deviation in enumerate((0.1, 0.2, 0.3, 0.4)):
        assert found["low"][place] == pytest.approx(place + 1 - 1.645 * deviation, abs=0.1 * deviation)
        assert found["high"][place] == pytest.approx(place + 1 + 1.645 * deviation, abs=0.1 * deviation)
    assert found["determined"].to_list() == [True] * 4


def test_an_interval_of_reward_values_counts_how_weights_vary_together():
    learned = reward((0.1, 0.1, 0.1, 0.1), shared=1.0)
    low, high = learned.interval(0.8)
    assert low.shape == high.shape == (2, 3, 2)
    assert (low < learned.table).all()
    assert (learned.table < high).all()
    covariance = 0.01 * np.eye(4)
    covariance[2:, 2:] += 1.0
    deviations = np.sqrt(np.einsum("slam,mn,slan->sla", TABLE, covariance, TABLE))
    np.testing.assert_allclose(high - low, 2 * 1.2816 * deviations, rtol=0.07)


def test_a_weight_that_is_as_open_as_before_was_never_put_to_the_test():
    assert reward((0.1, PRIOR, 0.1, 0.1)).undetermined == ["value of host 2: not pinned down by what was seen"]
    assert reward((0.1, 0.45 * PRIOR, 0.1, 0.1)).undetermined == []
    assert reward((0.1, 0.55 * PRIOR, 0.1, 0.1)).determined.tolist() == [True, False, True, True]


def test_weights_that_are_open_only_together_share_a_common_constant():
    # Each of the two costs has 0.42 of the prior's deviation, their mean direction 0.59.
    learned = reward((0.01, 0.01, 0.01, 0.01), shared=0.42 * PRIOR)
    assert learned.determined.all()
    assert learned.undetermined == ["a common constant in cost of edge a, cost of edge b"]


def test_weights_that_are_open_only_against_each_other_are_a_combination():
    learned = reward((0.01,) * 4, shared=0.42 * PRIOR)
    learned.draws[:, 3] = 8.0 - learned.draws[:, 3]
    assert learned.undetermined == ["a combination of cost of edge a, cost of edge b"]


def test_intervals_change_their_unit_with_the_reward():
    learned = reward((0.1, 0.2, 0.3, PRIOR))
    other = learned.anchored("value of host 1", 10.0)
    np.testing.assert_allclose(np.stack(other.interval()), 10.0 * np.stack(learned.interval()))
    assert other.undetermined == learned.undetermined


@pytest.mark.parametrize("level", [0.0, 1.0, -0.5, 90, True])
def test_a_level_that_is_no_probability_is_refused(level: Any):
    with pytest.raises(InputError, match="level: cannot be"):
        reward((0.1,) * 4).interval(level)


def test_a_reward_without_a_posterior_has_no_interval():
    learned = LearnedReward(NAMES, np.ones(4), TabularFeatures(table=TABLE, names=NAMES))
    for ask in (learned.interval, learned.weight_intervals, lambda: learned.undetermined, lambda: learned.determined):
        with pytest.raises(InputError, match='lower_level="likelihood"'):
            ask()
