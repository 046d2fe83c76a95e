import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.experts.tabular_expert import RespondingExpert
from gsiirl.interaction import Proposal
from gsiirl.irl.expectations import sampled_reward_gradient
from gsiirl.theory.support.algorithm_1 import CHUNK, ExactExpert, Games, Run, algorithm_1, draw_games
from gsiirl.theory.support.games import DISCOUNT, TEMPERATURE
from gsiirl.theory.support.total_derivative import equilibria, lower_gradient

REGULARISATION = 0.05


@pytest.fixture(scope="module")
def games() -> Games:
    return draw_games(number=2, points=2)


@pytest.fixture(scope="module")
def run(games) -> Run:
    return algorithm_1(games, 1.0 / games.upper_smoothness, 2 * CHUNK, REGULARISATION)


def projected(points):
    return points / np.maximum(1.0, np.linalg.norm(points, axis=1, keepdims=True))


@pytest.mark.slow
def test_a_run_begins_where_its_games_say(games, run):
    assert run.commitments.shape == (2 * CHUNK, *games.commitments.shape)
    np.testing.assert_array_equal(run.commitments[0], games.commitments)
    np.testing.assert_array_equal(run.estimates[0], games.estimates)


@pytest.mark.slow
@pytest.mark.parametrize(("iteration", "steps"), [(2, 1), (15, 1), (16, 2), (CHUNK, 2)])
def test_an_iteration_is_t_k_inner_steps_and_one_step_of_ascent(games, run, iteration, steps):
    rates = np.asarray(1.0 / (games.lower_smoothness + REGULARISATION))
    before, commitments = np.asarray(run.estimates[iteration]), run.commitments[iteration]
    policies = equilibria(games.problems, commitments, run.estimates[iteration]).learner_policy
    gradients = jax.jit(jax.vmap(lower_gradient, (0, 0, 0, None)))
    estimates = before
    for _ in range(steps):
        slopes = np.asarray(gradients(games.problems, policies, jnp.asarray(estimates), REGULARISATION))
        estimates = projected(estimates - rates[:, None] * slopes)
    np.testing.assert_allclose(run.estimates[iteration + 1], estimates, rtol=1e-9)
    assert np.abs(estimates - before).max() > 1e-6
    direction = np.asarray(equilibria(games.problems, commitments, jnp.asarray(estimates)).through_learner)
    moved = projected(np.asarray(commitments) + direction / np.asarray(games.upper_smoothness)[:, None])
    np.testing.assert_allclose(run.commitments[iteration + 1], moved, rtol=1e-9)


def test_smoothness_is_no_less_than_the_curvature_at_a_drawn_point(games):
    more = draw_games(number=2, points=4)
    for fewer_points, more_points in (
        (games.upper_smoothness, more.upper_smoothness),
        (games.lower_smoothness, more.lower_smoothness),
    ):
        assert np.all(np.asarray(fewer_points) > 0.0)
        assert np.all(np.asarray(more_points) >= np.asarray(fewer_points))


def test_exact_demonstrations_are_what_sampled_ones_scatter_around(games):
    problem = jax.tree.map(lambda leaf: leaf[0], games.problems)
    policy = equilibria(games.problems, games.commitments, games.estimates).learner_policy[0]
    exact = ExactExpert(problem).meet(None, Proposal(policy), 0, jax.random.key(0))[1].demonstrations
    expert = RespondingExpert(problem.game, problem.true_expert_reward(), TEMPERATURE, DISCOUNT)
    reward = problem.bilevel(0.0).expert_reward

    @jax.jit
    @jax.vmap
    def sampled(key):
        return sampled_reward_gradient(reward, expert.demonstrate(policy, 50, key), DISCOUNT, policy.dtype)

    draws = np.asarray(sampled(jax.random.split(jax.random.key(1), 60)))
    error = draws.std(axis=0) / np.sqrt(len(draws))
    assert np.all(error > 0)
    assert np.all(np.abs(draws.mean(axis=0) - np.asarray(exact)) <= 4.5 * error)


def test_iterations_come_in_chunks(games):
    with pytest.raises(ValueError, match=f"a multiple of {CHUNK}, got 7"):
        algorithm_1(games, games.upper_smoothness, 7, REGULARISATION)
