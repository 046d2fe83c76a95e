import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.hypergradients import Implicit
from gsiirl.theory.support.algorithm_1 import Games, draw_games
from gsiirl.theory.support.total_derivative import equilibria, minimisers, total_derivatives

REGULARISATION = 0.05


@pytest.fixture(scope="module")
def games() -> Games:
    return draw_games(number=2, points=2)


def test_the_total_derivative_is_that_of_f_at_the_moving_minimiser(games):
    def solved(commitments):
        played = equilibria(games.problems, commitments, games.estimates)
        return equilibria(
            games.problems, commitments, minimisers(games.problems, played.learner_policy, REGULARISATION)
        )

    def objective(commitments):
        return np.asarray(solved(commitments).objective)

    value, found = total_derivatives(games.problems, games.commitments, games.estimates, REGULARISATION)
    np.testing.assert_allclose(value, objective(games.commitments), rtol=1e-12)
    step = 1e-4
    expected = np.stack(
        [
            (objective(games.commitments + shift[None, :]) - objective(games.commitments - shift[None, :])) / (2 * step)
            for shift in step * jnp.eye(found.shape[1])
        ],
        axis=1,
    )
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())
    # The response is a part of it that this comparison would miss at once.
    alone = solved(games.commitments).through_learner
    assert np.abs(np.asarray(alone) - expected).max() > 1e-3 * np.abs(expected).max()


@pytest.mark.slow
def test_it_is_that_of_the_implicit_estimator_on_the_bilevel_problem(games):
    problem = jax.tree.map(lambda leaf: leaf[1], games.problems)
    commitment, believed, step = games.commitments[1], games.estimates[1], 1e-5
    bilevel = problem.bilevel(REGULARISATION)
    demonstrated = jax.jit(lambda theta: problem.demonstrated(bilevel, theta, believed))
    shifts = step * jnp.eye(commitment.shape[0])
    moved = jnp.stack(
        [(demonstrated(commitment + each) - demonstrated(commitment - each)) / (2 * step) for each in shifts], axis=1
    )
    policies = equilibria(games.problems, games.commitments, games.estimates).learner_policy
    solution = minimisers(games.problems, policies, REGULARISATION)[1]

    @jax.jit
    def estimate(moved):
        level = bilevel.problem(believed, demonstrated(commitment), moved)
        return Implicit("measured").hypergradient(level, commitment, solution).value

    _, total = total_derivatives(games.problems, games.commitments, games.estimates, REGULARISATION)
    np.testing.assert_allclose(total[1], estimate(moved), rtol=0, atol=1e-7)
    # Demonstrations that are held give another derivative.
    assert float(jnp.linalg.norm(total[1] - estimate(0.0 * moved))) > 1e-3
