import numpy as np
import pytest

from gsiirl.theory.support.quadratic import Quadratic


@pytest.mark.parametrize("on_sphere", [False, True])
@pytest.mark.parametrize("response", ["frozen", "measured"])
def test_closed_form_of_the_response_is_the_change_of_the_constrained_solution(on_sphere, response):
    assert Quadratic.draw(3, on_sphere).response_error(response) <= 1e-8


def test_lower_solution_meets_the_optimality_conditions():
    for on_sphere in (False, True):
        problem = Quadratic.draw(4, on_sphere)
        solution, multiplier = problem.solution
        demonstrated = problem.offset + problem.moving @ problem.point
        gradient = problem.hessian @ solution + problem.mixed @ problem.point - demonstrated
        np.testing.assert_allclose(gradient, -multiplier * solution, atol=1e-12)
        assert (multiplier > 0.0) == on_sphere
        np.testing.assert_allclose(np.linalg.norm(solution), 1.0 if on_sphere else 0.5, rtol=1e-12)


def test_frozen_and_measured_differ():
    problem = Quadratic.draw(0, on_sphere=True)
    frozen, measured = problem.hypergradient("frozen"), problem.hypergradient("measured")
    assert np.linalg.norm(frozen - measured) > 0.1 * np.linalg.norm(measured)
