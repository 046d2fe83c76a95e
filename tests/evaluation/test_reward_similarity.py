import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.evaluation import RewardSimilarity
from gsiirl.rewards.linear import IndicatorFeatures, TabularFeatures
from tests import helpers, oracles

DISCOUNT = 0.9


def problem(seed: int):
    dense = oracles.random_game(seed, 4, 2, 3)
    features = np.random.default_rng(seed).normal(size=(4, 2, 3, 5))
    table = TabularFeatures(table=jnp.asarray(features), names=tuple("abcde"))
    similarity = RewardSimilarity.of(helpers.tabular_game(dense), table, DISCOUNT)
    first, second = np.random.default_rng(seed + 50).normal(size=(2, 5))
    return features, similarity, first, second


@pytest.mark.parametrize("seed", range(3))
def test_pearson_is_that_of_the_tables(seed):
    features, similarity, first, second = problem(seed)
    expected = np.corrcoef((features @ first).ravel(), (features @ second).ravel())[0, 1]
    np.testing.assert_allclose(similarity.pearson(jnp.asarray(first), jnp.asarray(second)), expected, atol=1e-13)


@pytest.mark.parametrize("seed", range(3))
def test_epic_agrees_with_the_oracle(seed):
    features, similarity, first, second = problem(seed)
    tables = [np.broadcast_to((features @ weights).reshape(4, 6)[:, :, None], (4, 6, 4)) for weights in (first, second)]
    expected = oracles.epic_distance(tables[0], tables[1], DISCOUNT)
    np.testing.assert_allclose(similarity.epic(jnp.asarray(first), jnp.asarray(second)), expected, atol=1e-12)


def test_a_reward_is_like_its_positive_multiples_and_unlike_its_negative():
    _, similarity, first, _ = problem(0)
    one = jnp.asarray(first)
    assert float(similarity.pearson(one, 3.0 * one)) == pytest.approx(1.0)
    assert float(similarity.epic(one, 3.0 * one)) == pytest.approx(0.0, abs=1e-7)
    assert float(similarity.epic(one, -one)) == pytest.approx(1.0)


def test_a_constant_reward_is_like_nothing():
    _, similarity, first, _ = problem(0)
    assert float(similarity.pearson(jnp.asarray(first), jnp.zeros(5))) == 0.0


def test_a_reward_that_is_constant_but_for_rounding_is_like_nothing():
    # One feature an action of the expert: the same weight on all of them is a constant.
    features = np.broadcast_to(np.eye(3)[None, None] * (1 + 1e-15), (4, 2, 3, 3))
    table = TabularFeatures(table=jnp.asarray(features), names=tuple("abc"))
    similarity = RewardSimilarity.of(helpers.tabular_game(oracles.random_game(0, 4, 2, 3)), table, DISCOUNT)
    constant, other = jnp.full(3, 0.1), jnp.asarray([0.3, -0.2, 0.7])
    assert float(similarity.pearson(other, constant)) == 0.0
    assert float(similarity.pearson(other, 2.0 * other)) == pytest.approx(1.0)


def starc_canonical(game: oracles.Game, reward: np.ndarray) -> np.ndarray:
    """r(s, a) - V(s) + gamma E[V(s')|s, a], V the value of uniform play for ever, by a linear system."""
    states = reward.shape[0]
    chain = game.transition.mean(axis=(1, 2))
    values = np.linalg.solve(np.eye(states) - DISCOUNT * chain, reward.mean(axis=(1, 2)))
    return reward - values[:, None, None] + DISCOUNT * game.transition @ values


@pytest.mark.parametrize("seed", range(3))
def test_starc_is_the_distance_of_canonical_rewards(seed: int) -> None:
    features, similarity, first, second = problem(seed)
    one, other = (starc_canonical(oracles.random_game(seed, 4, 2, 3), features @ each) for each in (first, second))
    expected = 0.5 * np.linalg.norm(one / np.linalg.norm(one) - other / np.linalg.norm(other))
    assert float(similarity.starc(jnp.asarray(first), jnp.asarray(second))) == pytest.approx(expected, abs=1e-12)


def tabular(seed: int) -> tuple[oracles.Game, RewardSimilarity, np.ndarray]:
    """A game with a weight for every state-action, and a reward."""
    game = oracles.random_game(seed, 4, 2, 3)
    features = IndicatorFeatures(shape=(4, 2, 3), names=())
    similarity = RewardSimilarity.of(helpers.tabular_game(game), features, DISCOUNT)
    return game, similarity, np.random.default_rng(seed).normal(size=(4, 2, 3))


def weights(reward: np.ndarray) -> jnp.ndarray:
    return jnp.asarray(reward.ravel())


@pytest.mark.parametrize("seed", range(5))
def test_distances_ignore_what_they_should_and_nothing_else(seed: int) -> None:
    game, similarity, reward = tabular(seed)
    potential = np.random.default_rng(seed + 10).normal(size=4)
    shaping = DISCOUNT * game.transition @ potential - potential[:, None, None]
    one = weights(reward)
    assert float(similarity.epic(one, weights(2.5 * reward + 3.0))) < 1e-8
    assert float(similarity.starc(one, weights(2.5 * reward + 3.0))) < 1e-8
    assert float(similarity.starc(one, weights(2.5 * reward + shaping))) < 1e-8
    assert float(similarity.epic(one, weights(2.5 * reward + shaping))) > 0.05
    assert abs(1.0 - float(similarity.pearson(one, weights(2.5 * reward + 3.0)))) < 1e-8


@pytest.mark.parametrize("seed", range(5))
def test_the_opposite_reward_is_farthest_and_an_unrelated_one_between(seed: int) -> None:
    _, similarity, reward = tabular(seed)
    unrelated = np.random.default_rng(seed + 20).normal(size=reward.shape)
    for measure in (similarity.epic, similarity.starc):
        near, between, far = (
            float(measure(weights(reward), weights(each))) for each in (reward + 0.1 * unrelated, unrelated, -reward)
        )
        assert near < 0.2 < between < 0.95 < far
        assert far == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_directions_that_are_projected_out_do_not_count(seed: int) -> None:
    _, similarity, reward = tabular(seed)
    random = np.random.default_rng(seed + 30)
    directions = random.normal(size=(24, 3))
    part = similarity.without(jnp.asarray(directions))
    other = 2.0 * reward + (directions @ random.normal(size=3)).reshape(reward.shape)
    for measure in (part.epic, part.starc):
        assert float(measure(weights(reward), weights(other))) < 1e-8
        assert float(measure(weights(reward), weights(-other))) == pytest.approx(1.0, abs=1e-8)
    assert abs(1.0 - float(part.pearson(weights(reward), weights(other)))) < 1e-8
    assert float(similarity.starc(weights(reward), weights(other))) > 0.1
    assert float(part.starc(weights(reward), weights((directions @ np.ones(3)).reshape(reward.shape)))) == 0.5**0.5
