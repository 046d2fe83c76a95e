import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.rewards import attack_graph as rewards
from gsiirl.rewards.linear import Linear
from gsiirl.types import Sides
from tests import helpers


@pytest.mark.parametrize("variant", ["general_sum", "zero_sum"])
@pytest.mark.parametrize("no_op", [False, True])
def test_true_rewards_are_those_of_the_dense_game(variant, no_op):
    network, game, dense = helpers.small_attack_graph(variant, no_op)
    attack, dependent = rewards.attack_features(game), rewards.commitment_features(game)
    np.testing.assert_allclose(
        attack.payoff(jnp.asarray(rewards.expert_weights(network))).dense(), dense.expert_reward, atol=1e-15
    )
    np.testing.assert_allclose(
        dependent.payoff(jnp.asarray(rewards.dependent_weights(network))).dense(), dense.dependent_reward, atol=1e-15
    )
    np.testing.assert_allclose(rewards.own_reward(game, network).dense(), dense.own_reward, atol=1e-15)


@pytest.mark.parametrize("make", [rewards.attack_features, rewards.dependent_features, rewards.commitment_features])
def test_features_of_one_action_agree_with_the_payoff_over_all(make):
    _, game, _ = helpers.small_attack_graph(no_op=True)
    reward = Linear(make(game), 2.0)
    theta = reward.initial_parameters(jax.random.key(0), jnp.dtype(float))
    table = reward.payoff(theta).dense()
    learner, expert = jnp.meshgrid(jnp.arange(7), jnp.arange(7), indexing="ij")

    def of_state(state):
        return jax.vmap(jax.vmap(lambda one, other: reward(theta, state, Sides(one, other))))(learner, expert)

    np.testing.assert_allclose(jax.vmap(of_state)(jnp.arange(16)), table, atol=1e-14)
    assert len(reward.features.names) == reward.number_of_parameters == theta.shape[0]


def test_initial_parameters_lie_in_the_unit_ball():
    _, game, _ = helpers.small_attack_graph()
    reward = Linear(rewards.attack_features(game), 2.0)
    drawn = jax.vmap(lambda key: reward.initial_parameters(key, jnp.dtype(float)))(
        jax.random.split(jax.random.key(1), 500)
    )
    norms = jnp.linalg.norm(drawn, axis=1)
    assert float(norms.max()) <= 1.0
    # Uniform in the ball of R^10: P(norm <= 0.9) = 0.9^10.
    assert abs(float((norms <= 0.9).mean()) - 0.9**10) < 0.1
