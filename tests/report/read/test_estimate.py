"""Means, spreads and intervals over seeds."""

import numpy as np
import pytest
from scipy import stats

from gsiirl.report.read.estimate import Estimate


@pytest.mark.parametrize("count", [2, 3, 4, 11, 12, 31, 1000])
def test_the_interval_is_students(count: int) -> None:
    values = np.arange(count) ** 1.5
    estimate = Estimate.over(values)
    low, high = stats.t.interval(0.95, count - 1, loc=values.mean(), scale=stats.sem(values))
    assert (estimate.mean, estimate.count) == (pytest.approx(values.mean()), count)
    assert estimate.std == pytest.approx(values.std(ddof=1))
    assert (estimate.low, estimate.high) == (pytest.approx(low, rel=1e-9), pytest.approx(high, rel=1e-9))


def test_one_seed_has_no_spread() -> None:
    assert Estimate.over(np.array([2.5])) == Estimate(2.5, 0.0, 2.5, 2.5, 1)


def test_one_seed_is_shown_without_a_spread() -> None:
    assert str(Estimate.over(np.array([2.5]))) == "2.50"
    assert str(Estimate.over(np.array([2.5, 2.5]))) == "2.50 ± 0.00"
