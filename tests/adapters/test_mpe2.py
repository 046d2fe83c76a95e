"""mpe2 pays a pair of policies what our port of it pays them."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mpe2_world import state_of

from gsiirl.adapters import mpe2
from gsiirl.adapters.numpy_policy import NumpyPolicy
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.equilibria.policy_weights import weights_of
from gsiirl.games import Deception
from gsiirl.games.rollout import play
from gsiirl.rewards.continuous import mean_return
from gsiirl.rewards.deception import adversary_reward, dependent_reward, own_reward
from gsiirl.types import Sides

HIDDEN = 16
EPISODES = 5


def networks(seed: int) -> Sides[PolicyNetwork]:
    """Random policies, far from small actions."""
    keys = jax.random.split(jax.random.key(seed))
    sizes = zip(keys, mpe2.OBSERVATION_SIZES, mpe2.ACTION_SIZES, strict=True)
    learner, expert = (PolicyNetwork.create(inputs, outputs, HIDDEN, key) for key, inputs, outputs in sizes)
    return jax.tree.map(lambda leaf: 3.0 * leaf, Sides(learner, expert))


def in_numpy(policies: Sides[PolicyNetwork]) -> tuple[NumpyPolicy, NumpyPolicy]:
    """The same policies as a run keeps them: the second of two seeds."""
    weights = {
        name: np.stack([np.zeros_like(array), np.asarray(array)])
        for name, array in weights_of(learner=policies.learner, expert=policies.expert).items()
    }
    return NumpyPolicy.of(weights, "learner", 1), NumpyPolicy.of(weights, "expert", 1)


def test_a_policy_in_numpy_acts_as_the_network():
    policies = networks(0)
    random = np.random.default_rng(0)
    for policy, network in zip(in_numpy(policies), (policies.learner, policies.expert), strict=True):
        size = network.layers[0].in_features - 1  # pyright: ignore[reportOperatorIssue] (a number)
        for observation in random.uniform(-2.0, 2.0, (10, size)).astype(np.float32):
            time = np.float32(random.random())
            action = policy(observation, float(time))
            assert action.dtype == np.float32
            np.testing.assert_allclose(action, network(jnp.asarray(observation), jnp.asarray(time)), atol=1e-6)


@pytest.mark.parametrize("action", [(0.3, -0.7), (-1.0, 1.0), (0.0, 0.0)])
def test_pushes_amount_to_the_action(action: tuple[float, float]):
    none, left, right, down, up = mpe2.pushes(np.array(action, np.float32))
    assert none == 0.0
    assert min(left, right, down, up) >= 0.0
    np.testing.assert_allclose((right - left, up - down), action, atol=1e-7)


@pytest.mark.parametrize("horizon", [25, 7])
def test_returns_are_those_of_the_port(horizon: int):
    policies, game = networks(1), Deception(horizon)
    environment = mpe2.simple_adversary(horizon)
    learner, expert = in_numpy(policies)

    @jax.jit
    def in_port(start):
        episode = jax.tree.map(lambda leaf: leaf[None], play(game, policies, start))
        rewards = (lambda seen: own_reward(seen) + dependent_reward(seen), adversary_reward)
        return [mean_return(reward, episode, 1.0) for reward in rewards]

    for seed in range(EPISODES):
        environment.reset(seed=seed)
        expected = in_port(state_of(environment.unwrapped.world))  # pyright: ignore[reportAttributeAccessIssue]
        np.testing.assert_allclose(mpe2.play(environment, horizon, learner, expert, seed), expected, atol=1e-3)
        assert environment.agents == []


def test_an_episode_is_the_same_again():
    environment = mpe2.simple_adversary(25)
    pair = in_numpy(networks(2))
    first, other, again = (mpe2.play(environment, 25, *pair, seed) for seed in (3, 4, 3))
    assert first == again
    assert first != other
