import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.evaluation import RewardSimilarity
from gsiirl.rewards.linear import TabularFeatures
from tests import helpers, oracles


def problem(seed: int):
    dense = oracles.random_game(seed, 4, 2, 3)
    features = np.random.default_rng(seed).normal(size=(4, 2, 3, 5))
    table = TabularFeatures(table=jnp.asarray(features), names=tuple("abcde"))
    similarity = RewardSimilarity.of(helpers.tabular_game(dense), table)
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
    expected = oracles.epic_distance(tables[0], tables[1], 0.9)
    np.testing.assert_allclose(similarity.epic(jnp.asarray(first), jnp.asarray(second), 0.9), expected, atol=1e-12)


def test_a_reward_is_like_its_positive_multiples_and_unlike_its_negative():
    _, similarity, first, _ = problem(0)
    one = jnp.asarray(first)
    assert float(similarity.pearson(one, 3.0 * one)) == pytest.approx(1.0)
    assert float(similarity.epic(one, 3.0 * one, 0.9)) == pytest.approx(0.0, abs=1e-7)
    assert float(similarity.epic(one, -one, 0.9)) == pytest.approx(1.0)


def test_a_constant_reward_is_like_nothing():
    _, similarity, first, _ = problem(0)
    assert float(similarity.pearson(jnp.asarray(first), jnp.zeros(5))) == 0.0


def test_a_reward_that_is_constant_but_for_rounding_is_like_nothing():
    # One feature an action of the expert: the same weight on all of them is a constant.
    features = np.broadcast_to(np.eye(3)[None, None] * (1 + 1e-15), (4, 2, 3, 3))
    table = TabularFeatures(table=jnp.asarray(features), names=tuple("abc"))
    similarity = RewardSimilarity.of(helpers.tabular_game(oracles.random_game(0, 4, 2, 3)), table)
    constant, other = jnp.full(3, 0.1), jnp.asarray([0.3, -0.2, 0.7])
    assert float(similarity.pearson(other, constant)) == 0.0
    assert float(similarity.pearson(other, 2.0 * other)) == pytest.approx(1.0)
