import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.theory.checks import theorem_2


def mapping(point, gradient, step: float) -> np.ndarray:
    found = theorem_2.gradient_mappings(jnp.asarray(point)[None], jnp.asarray(gradient)[None], jnp.asarray([step]))
    return np.asarray(found[0])


def test_the_gradient_mapping_is_the_gradient_inside_the_ball():
    gradient = np.array([0.3, -2.0, 0.5])
    np.testing.assert_allclose(mapping([0.1, 0.2, -0.3], gradient, 0.1), gradient, rtol=1e-13)


def test_the_gradient_mapping_vanishes_at_a_constrained_maximiser_and_only_there():
    point, step = np.array([0.6, 0.0, -0.8]), 1e-6
    np.testing.assert_allclose(mapping(point, 3.0 * point, step), 0.0, atol=1e-9)
    tangent = np.array([0.8, 1.0, 0.6])
    np.testing.assert_allclose(mapping(point, 3.0 * point + tangent, step), tangent, rtol=0, atol=1e-4)
    # A gradient that points inwards moves the point: it is no maximiser.
    inwards = -3.0 * point
    np.testing.assert_allclose(mapping(point, inwards, step), inwards, rtol=1e-9)


def test_averages_are_of_the_first_iterations():
    squared = np.arange(12.0).reshape(6, 2)
    measured = theorem_2.Measured(squared, squared, np.zeros((6, 2, 3)))
    np.testing.assert_array_equal(measured.averages([1, 3]), [[0.0, 1.0], [2.0, 3.0]])


def test_a_slope_can_be_that_of_the_last_k_alone():
    averages = np.array([[1.0], [1.0], [0.5], [0.25]])
    rule = theorem_2.Rule((1, 2, 4, 8), averages, theorem_2.Measured(averages, averages, averages[..., None]))
    assert rule.slope(last=3) == pytest.approx(-1.0, abs=1e-12)
    assert rule.slowest() == rule.slope() == pytest.approx(-0.7, abs=1e-12)


@pytest.mark.slow
def test_the_quick_check_holds():
    assert theorem_2.check(quick=True).holds
