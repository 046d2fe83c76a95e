"""Means, spreads and intervals over seeds."""

import numpy as np
import pytest
from scipy import stats

from gsiirl.report.estimate import Estimate, format_number, t_quantile


@pytest.mark.parametrize("freedom", [*range(1, 31), 99, 999])
def test_t_quantiles_are_those_of_the_distribution(freedom: int) -> None:
    assert t_quantile(freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=1e-4)


def test_the_interval_is_students() -> None:
    values = np.array([1.0, 2.0, 4.0, 8.0])
    estimate = Estimate.over(values)
    low, high = stats.t.interval(0.95, 3, loc=values.mean(), scale=stats.sem(values))
    assert (estimate.mean, estimate.count) == (3.75, 4)
    assert estimate.std == pytest.approx(values.std(ddof=1))
    assert (estimate.low, estimate.high) == (pytest.approx(low, rel=1e-4), pytest.approx(high, rel=1e-4))


def test_one_seed_has_no_spread() -> None:
    assert Estimate.over(np.array([2.5])) == Estimate(2.5, 0.0, 2.5, 2.5, 1)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (-16.96, "\N{MINUS SIGN}16.96"),
        (-0.0001, "0.000"),
        (-0.021, "\N{MINUS SIGN}0.021"),
        (0.0, "0.00"),
        (3.0, "3.00"),
    ],
)
def test_numbers_read_well(value: float, text: str) -> None:
    assert format_number(value) == text
