import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria import nash_gap, regularised_nash_gap
from gsiirl.games import DensePayoff, TabularGame
from gsiirl.types import Sides
from tests import helpers, oracles


@pytest.mark.parametrize("seed", range(3))
def test_gaps_of_random_policies_agree_with_the_oracle(seed):
    dense = oracles.random_game(seed, 3, 2, 4)
    played = Sides(oracles.random_policy(seed, helpers.HORIZON, 3, 2), oracles.random_policy(9, helpers.HORIZON, 3, 4))
    policies = Sides(jnp.asarray(played.learner), jnp.asarray(played.expert))
    game, rewards = helpers.tabular_game(dense), helpers.rewards_of(dense)
    expected = oracles.nash_gap(dense, played.learner, played.expert, helpers.DISCOUNT)
    np.testing.assert_allclose(nash_gap(game, rewards, policies, helpers.DISCOUNT), expected, atol=1e-12)
    expected = oracles.soft_nash_gap(dense, played.learner, played.expert, helpers.DISCOUNT, 0.3)
    np.testing.assert_allclose(
        regularised_nash_gap(game, rewards, policies, helpers.DISCOUNT, 0.3), expected, atol=1e-12
    )


def one_shot(learner: list[list[float]], expert: list[list[float]]):
    shape = (1, len(learner), len(learner[0]), 1)
    game = TabularGame.from_arrays((np.zeros(shape, int), np.ones(shape)), initial=[1.0], horizon=1)
    return game, Sides(DensePayoff(jnp.asarray([learner])), DensePayoff(jnp.asarray([expert])))


def test_matching_pennies_has_no_gap_at_uniform_play_and_a_gap_of_two_at_pure_play():
    game, rewards = one_shot([[1.0, -1.0], [-1.0, 1.0]], [[-1.0, 1.0], [1.0, -1.0]])
    uniform = jnp.full((1, 1, 2), 0.5)
    assert float(nash_gap(game, rewards, Sides(uniform, uniform), 1.0)) == pytest.approx(0.0, abs=1e-15)
    pure = jnp.asarray([[[1.0, 0.0]]])
    assert float(nash_gap(game, rewards, Sides(pure, pure), 1.0)) == pytest.approx(2.0)


def test_mutual_defection_in_the_prisoners_dilemma_has_no_gap():
    game, rewards = one_shot([[3.0, 0.0], [5.0, 1.0]], [[3.0, 5.0], [0.0, 1.0]])
    defect = jnp.asarray([[[0.0, 1.0]]])
    assert float(nash_gap(game, rewards, Sides(defect, defect), 1.0)) == 0.0
    cooperate = jnp.asarray([[[1.0, 0.0]]])
    assert float(nash_gap(game, rewards, Sides(cooperate, cooperate), 1.0)) == 4.0
