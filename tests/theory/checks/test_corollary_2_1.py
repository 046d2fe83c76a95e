import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria.response import respond
from gsiirl.irl.expectations import expected_return, reward_gradient_expectation
from gsiirl.theory.checks import corollary_2_1
from gsiirl.theory.support.algorithm_1 import CHUNK, Games, draw_games
from gsiirl.theory.support.games import DISCOUNT, TEMPERATURE
from gsiirl.theory.support.total_derivative import equilibria, minimisers
from gsiirl.types import Sides


@pytest.fixture(scope="module")
def games() -> Games:
    return draw_games(number=2, points=2)


@pytest.fixture(scope="module")
def policies(games) -> jax.Array:
    """What is played at the points that were drawn."""
    return equilibria(games.problems, games.commitments, games.estimates).learner_policy


def answered(problem, policy, payoff):
    return Sides(policy, respond(problem.game, policy, payoff, TEMPERATURE, DISCOUNT).policy)


@pytest.mark.parametrize("regularisation", [0.1, 1e-3])
def test_the_gap_at_the_minimiser_is_its_floor(games, policies, regularisation):
    """Fitted and true expert are played out here, with nothing of the lower level's gradient."""
    for number, minimiser in enumerate(np.asarray(minimisers(games.problems, policies, regularisation))):
        problem = jax.tree.map(lambda leaf: leaf[number], games.problems)  # noqa: B023 (called at once)
        reward = problem.bilevel(0.0).expert_reward
        fitted, true = (
            reward_gradient_expectation(problem.game, reward, answered(problem, policies[number], payoff), DISCOUNT)
            for payoff in (reward.payoff(jnp.asarray(minimiser)), problem.true_expert_reward())
        )
        difference = np.asarray(fitted - true)
        # Not only its length: the whole vector is −τλθ_e*.
        np.testing.assert_allclose(difference, -TEMPERATURE * regularisation * minimiser, rtol=0, atol=1e-9)
        assert np.linalg.norm(minimiser) < 1.0


def test_the_feature_difference_gives_the_difference_of_returns(games, policies):
    features = corollary_2_1.feature_differences(games.problems, policies, games.estimates)
    problem = jax.tree.map(lambda leaf: leaf[0], games.problems)
    reward = problem.bilevel(0.0).expert_reward.payoff(games.estimates[0])
    fitted, true = (
        expected_return(problem.game, reward, answered(problem, policies[0], payoff), DISCOUNT)
        for payoff in (reward, problem.true_expert_reward())
    )
    assert float(fitted - true) == pytest.approx(float(np.asarray(games.estimates[0]) @ features[0]), rel=1e-9)


@pytest.mark.slow
def test_a_run_ends_at_its_floor(games):
    found = corollary_2_1.measure_gaps(games, 0.1, CHUNK)
    assert found.gaps.shape == found.differences.shape == (CHUNK, 2)
    np.testing.assert_allclose(found.settled, found.floors, rtol=1e-6)
    np.testing.assert_allclose(found.exact, found.floors, rtol=1e-9)
    # It had not ended after its first iterations: so few inner steps leave it elsewhere, above its end or below.
    assert np.all(np.abs(found.gaps[3] / found.floors - 1.0) > 0.05)
    assert np.all(found.differences <= found.gaps)


def test_more_inner_steps_end_at_the_minimiser(games, policies):
    # The smoothness was taken at two points alone, and may be larger here.
    rates = 0.5 / (games.lower_smoothness + 0.05)
    found = corollary_2_1.settled_estimates(games.problems, policies, games.estimates, jnp.asarray(0.05), rates)
    expected = minimisers(games.problems, policies, 0.05)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_the_rate_is_read_off_before_the_floor():
    steps = np.arange(1.0, 201.0)
    # Two power laws, the first of which meets its floor; the third run begins at its floor.
    gaps = np.stack([np.maximum(steps**-0.5, 0.2), steps**-1.5, np.full(200, 0.1)], axis=1)
    floors = np.array([0.1, 1e-9, 0.1])
    found = corollary_2_1.Gaps(gaps, gaps, floors, floors, floors)
    assert corollary_2_1.rates(found) == pytest.approx([-0.5, -1.5], abs=1e-12)


@pytest.mark.slow
def test_the_quick_check_holds():
    assert corollary_2_1.check(quick=True).holds
