import math

import numpy as np
import pytest

from gsiirl.theory.support.curves import curve, extremes, fitted_slope, guide


def test_the_slope_is_that_of_a_power_law():
    ks = [25, 50, 100, 400]
    assert fitted_slope(ks, [3.0 * k**-0.7 for k in ks]) == pytest.approx(-0.7, abs=1e-12)
    # Not a power law: least squares over the logarithms, here by hand for three points.
    assert fitted_slope([1, np.e, np.e**2], [1.0, np.e, np.e]) == pytest.approx(0.5, abs=1e-12)


def test_a_guide_is_a_power_of_x_from_end_to_end():
    line = guide("slope -1/2", range(1, 5), 3.0, -0.5)
    assert (line.x, line.y, line.role) == ([1.0, 4.0], [3.0, 1.5], "guide")


def test_a_curve_has_numbers_of_python():
    line = curve("ours", np.array([1, 2]), np.array([0.5, 0.25]))
    assert (line.x, line.y) == ([1.0, 2.0], [0.5, 0.25])
    assert all(type(number) is float for number in (*line.x, *line.y))


def test_extremes_share_their_bounds_and_pass_over_no_nan():
    smallest, largest = extremes("slope", [1.0, 3.0, 2.0], "of the games", 0.5, 2.5)
    assert (smallest.name, smallest.value, smallest.holds) == ("slope, smallest of the games", 1.0, True)
    assert (largest.name, largest.value, largest.holds) == ("slope, largest of the games", 3.0, False)
    assert all(math.isnan(each.value) for each in extremes("slope", [1.0, math.nan], "of all", 0.0, 2.0))
