import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria.response import respond
from gsiirl.irl.expectations import expected_return, reward_gradient_expectation
from gsiirl.theory.checks import corollary_2_1, theorem_2
from gsiirl.theory.support.games import DISCOUNT, TEMPERATURE
from gsiirl.types import Sides

ITERATIONS = 4


@pytest.fixture(scope="module")
def games():
    return theorem_2.draw_games(number=2, points=2)


@pytest.fixture(scope="module")
def last(games):
    *_, iteration = theorem_2.algorithm_1(games, 1.0 / games.upper_smoothness, ITERATIONS, 0.1)
    return iteration


@pytest.mark.parametrize("regularisation", [0.1, 1e-3])
def test_the_gap_at_the_minimiser_is_its_floor(games, last, regularisation):
    """Fitted and true expert are played out here, with nothing of the lower level's gradient."""
    minimisers = theorem_2.minimisers(games.problems, last.played.learner_policy, regularisation)
    for number, minimiser in enumerate(np.asarray(minimisers)):
        problem = jax.tree.map(lambda leaf: leaf[number], games.problems)  # noqa: B023 (called at once)
        reward, policy = problem.bilevel(0.0).expert_reward, last.played.learner_policy[number]
        fitted, true = (
            reward_gradient_expectation(
                problem.game,
                reward,
                Sides(policy, respond(problem.game, policy, payoff, TEMPERATURE, DISCOUNT).policy),
                DISCOUNT,
            )
            for payoff in (reward.payoff(jnp.asarray(minimiser)), problem.true_expert_reward())
        )
        difference = np.asarray(fitted - true)
        # Not only its length: the whole vector is −τλθ_e*.
        np.testing.assert_allclose(difference, -TEMPERATURE * regularisation * minimiser, rtol=0, atol=1e-9)
        assert np.linalg.norm(minimiser) < 1.0


def test_the_feature_difference_gives_the_difference_of_returns(games, last):
    features = corollary_2_1.feature_differences(games, last.played.learner_policy, last.demonstrated, last.estimates)
    problem = jax.tree.map(lambda leaf: leaf[0], games.problems)
    policy, reward = last.played.learner_policy[0], problem.bilevel(0.0).expert_reward.payoff(last.estimates[0])
    fitted, true = (
        expected_return(
            problem.game,
            reward,
            Sides(policy, respond(problem.game, policy, payoff, TEMPERATURE, DISCOUNT).policy),
            DISCOUNT,
        )
        for payoff in (reward, problem.true_expert_reward())
    )
    assert float(fitted - true) == pytest.approx(float(np.asarray(last.estimates[0]) @ features[0]), rel=1e-9)


def test_a_run_ends_at_its_floor(games):
    found = corollary_2_1.measure_gaps(games, 0.1, ITERATIONS)
    assert found.gaps.shape == found.differences.shape == (ITERATIONS, 2)
    np.testing.assert_allclose(found.settled, found.floors, rtol=1e-6)
    np.testing.assert_allclose(found.exact, found.floors, rtol=1e-9)
    # It had not ended yet: the inner steps of so few iterations leave it elsewhere, above its end or below.
    assert np.all(np.abs(found.gaps[-1] / found.floors - 1.0) > 0.05)
    assert np.all(found.differences <= found.gaps)


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
