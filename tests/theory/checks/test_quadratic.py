import numpy as np
import pytest

from gsiirl.theory.checks.quadratic import (
    composed_errors,
    exact_errors,
    factor_scores,
    indefinite_fraction,
    printed_hessians,
)
from gsiirl.theory.support.quadratic import EXPERT_SIZE, LEARNER_SIZE, Quadratic


@pytest.mark.parametrize("response", ["frozen", "measured"])
def test_exact_estimators_give_the_closed_form_inside_and_on_the_sphere(response):
    problems = [Quadratic.draw(0, on_sphere=False), Quadratic.draw(0, on_sphere=True)]
    errors = exact_errors(problems, response)
    assert len(errors) == 3
    assert max(errors.values()) <= 1e-10


def test_factors_of_simultaneous_perturbation_are_unbiased():
    scores = factor_scores(Quadratic.draw(0, on_sphere=False), seed=0, draws=2000)
    entries = LEARNER_SIZE + EXPERT_SIZE + EXPERT_SIZE * (EXPERT_SIZE + 1) // 2 + EXPERT_SIZE * LEARNER_SIZE
    assert scores.size == entries
    assert np.abs(scores).max() <= 4.0
    # Were the draws not spread as their standard error says, the scores would be much smaller.
    assert np.sqrt(np.mean(scores**2)) > 0.5


def test_more_draws_bring_the_composed_hypergradient_nearer():
    problem = Quadratic.draw(0, on_sphere=False)
    few, many = (composed_errors(problem, draws, keys=16).mean() for draws in (10, 1000))
    assert many < 0.3 * few


def test_a_printed_hessian_has_rank_one_is_not_symmetric_and_always_indefinite():
    drawn = printed_hessians(Quadratic.draw(0, on_sphere=False), seed=0, draws=200)
    singular_values = np.linalg.svd(drawn, compute_uv=False)
    assert (singular_values[:, 1] <= 1e-10 * singular_values[:, 0]).all()
    assert (np.abs(drawn - np.swapaxes(drawn, 1, 2)).max(axis=(1, 2)) > 1e-3).all()
    assert indefinite_fraction(drawn) == 1.0


def test_a_definite_matrix_is_not_called_indefinite():
    matrices = np.stack([np.eye(EXPERT_SIZE), np.diag([1.0, -1.0, 1.0, 1.0])])
    assert indefinite_fraction(matrices) == 0.5


def test_printed_hessians_are_unbiased_all_the_same():
    problem = Quadratic.draw(0, on_sphere=False)
    drawn = printed_hessians(problem, seed=0, draws=20_000)
    error = drawn.std(axis=0) / np.sqrt(len(drawn))
    assert (np.abs(drawn.mean(axis=0) - problem.hessian) <= 4.0 * error + 1e-12).all()
