import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.games.rollout import rollout
from gsiirl.irl.expectations import (
    expected_return,
    reward_gradient_expectation,
    sampled_reward_gradient,
    state_distributions,
)
from gsiirl.rewards.linear import Linear, TabularFeatures
from gsiirl.types import Sides
from tests import helpers, oracles


def problem(seed: int = 0):
    dense = oracles.random_game(seed, 3, 2, 3)
    played = Sides(oracles.random_policy(1, helpers.HORIZON, 3, 2), oracles.random_policy(2, helpers.HORIZON, 3, 3))
    features = np.random.default_rng(seed).normal(size=(3, 2, 3, 5))
    return dense, played, features, jax.tree.map(jnp.asarray, played)


def test_state_distributions_are_the_oracles_occupancies():
    dense, played, _, policies = problem()
    expected = oracles.occupancy(dense.transition, dense.initial, played.learner, played.expert).sum(axis=(2, 3))
    np.testing.assert_allclose(state_distributions(helpers.tabular_game(dense), policies), expected, atol=1e-15)


def test_returns_agree_with_the_enumeration_of_paths():
    dense = oracles.random_game(0, 2, 2, 2)
    played = Sides(oracles.random_policy(1, 3, 2, 2), oracles.random_policy(2, 3, 2, 2))
    game, reward = helpers.tabular_game(dense, 3), helpers.rewards_of(dense).learner
    for discount in (0.9, 1.0):
        expected = oracles.path_value(
            dense.transition, dense.initial, dense.learner_reward, played.learner, played.expert, discount
        )
        found = expected_return(game, reward, jax.tree.map(jnp.asarray, played), discount)
        np.testing.assert_allclose(found, expected, atol=1e-14)


def test_reward_gradient_expectation_is_the_discounted_feature_expectation():
    dense, played, features, policies = problem()
    reward = Linear(TabularFeatures(table=jnp.asarray(features), names=tuple("abcde")), 3.0)
    occupancies = oracles.occupancy(dense.transition, dense.initial, played.learner, played.expert)
    expected = 3.0 * oracles.feature_expectation(occupancies, features, helpers.DISCOUNT)
    found = reward_gradient_expectation(helpers.tabular_game(dense), reward, policies, helpers.DISCOUNT)
    np.testing.assert_allclose(found, expected, atol=1e-13)


def test_sampled_gradient_converges_to_the_exact_one():
    dense, _, features, policies = problem()
    game = helpers.tabular_game(dense)
    reward = Linear(TabularFeatures(table=jnp.asarray(features), names=tuple("abcde")), 3.0)
    episodes = jax.vmap(lambda key: rollout(key, game, policies))(jax.random.split(jax.random.key(0), 20_000))
    exact = reward_gradient_expectation(game, reward, policies, helpers.DISCOUNT)
    each = jax.vmap(lambda one: sampled_reward_gradient(reward, jax.tree.map(lambda x: x[None], one), 0.9, exact.dtype))
    samples = each(episodes)
    np.testing.assert_allclose(
        sampled_reward_gradient(reward, episodes, 0.9, exact.dtype), samples.mean(axis=0), atol=1e-12
    )
    assert np.all(np.abs(samples.mean(axis=0) - exact) <= 5 * samples.std(axis=0) / np.sqrt(20_000))
