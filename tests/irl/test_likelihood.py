import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria.response import respond
from gsiirl.irl.expectations import reward_gradient_expectation, state_distributions
from gsiirl.irl.likelihood import played_gradient
from gsiirl.rewards.linear import Linear, TabularFeatures
from gsiirl.types import Sides
from tests import helpers, oracles

TEMPERATURE = 0.3


def problem(seed: int):
    dense = oracles.random_game(seed, 4, 3, 3)
    game = helpers.tabular_game(dense)
    features = np.random.default_rng(seed).normal(size=(4, 3, 3, 6))
    reward = Linear(TabularFeatures(table=jnp.asarray(features), names=tuple("abcdef")), 1.0)
    theta = jax.random.ball(jax.random.key(seed), 6)
    true = jax.random.ball(jax.random.key(seed + 100), 6)
    learner = oracles.random_policy(seed, helpers.HORIZON, 4, 3)
    expert = respond(game, jnp.asarray(learner), reward.payoff(true), TEMPERATURE, helpers.DISCOUNT).policy
    return dense, game, features, reward, theta, Sides(jnp.asarray(learner), expert)


def negative_log_likelihood(game, reward, parameters, demonstrated):
    """L without λ, of infinitely many demonstrations: the expectation over exact occupancies of the policies."""
    response = respond(game, demonstrated.learner, reward.payoff(parameters), TEMPERATURE, helpers.DISCOUNT)
    distributions = state_distributions(game, demonstrated)
    weights = helpers.DISCOUNT ** jnp.arange(game.horizon, dtype=distributions.dtype)
    log_likelihood = jnp.sum(demonstrated.expert * jnp.log(response.policy), axis=-1)
    return -jnp.sum(weights[:, None] * distributions * log_likelihood)


@pytest.mark.parametrize("seed", range(4))
def test_lemma_1_is_the_gradient_of_the_likelihood_for_exact_occupancies(seed):
    _, game, _, reward, theta, true = problem(seed)
    demonstrated = reward_gradient_expectation(game, reward, true, helpers.DISCOUNT)
    found = played_gradient(game, reward, theta, true.learner, demonstrated, TEMPERATURE, helpers.DISCOUNT)
    expected = jax.grad(lambda x: negative_log_likelihood(game, reward, x, true))(theta)
    assert float(jnp.linalg.norm(found - expected)) <= 1e-9 * float(jnp.linalg.norm(expected))


def test_likelihood_and_gradient_agree_with_the_oracle():
    dense, game, features, reward, theta, true = problem(7)
    exact = oracles.Demonstrations(
        oracles.occupancy(dense.transition, dense.initial, np.asarray(true.learner), np.asarray(true.expert)),
        np.asarray(true.learner),
    )
    settings = helpers.DISCOUNT, TEMPERATURE, 0.0
    expected = oracles.negative_log_likelihood(np.asarray(theta), features, dense.transition, exact, *settings)
    found = negative_log_likelihood(game, reward, theta, true)
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    gradient = oracles.lemma_1_gradient(np.asarray(theta), features, dense.transition, dense.initial, exact, *settings)
    demonstrated = reward_gradient_expectation(game, reward, true, helpers.DISCOUNT)
    found = played_gradient(game, reward, theta, true.learner, demonstrated, TEMPERATURE, helpers.DISCOUNT)
    np.testing.assert_allclose(found, gradient, rtol=1e-11)
