"""Behaviour cloning of a policy that a network of the same size can play."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.irl.cloning import cloned

pytestmark = pytest.mark.usefixtures("optax_promotion")

EPISODES, HORIZON = 40, 5


def test_a_clone_comes_to_do_what_it_is_shown() -> None:
    shown, start = (PolicyNetwork.create(3, 2, 8, jax.random.key(seed)) for seed in (0, 1))
    observations = jax.random.normal(jax.random.key(2), (EPISODES, HORIZON, 3), jnp.float32)
    times = jnp.arange(HORIZON, dtype=jnp.float32) / HORIZON

    def played(policy: PolicyNetwork) -> np.ndarray:
        return np.asarray(jax.vmap(jax.vmap(policy), (0, None))(observations, times))

    # Ten times as far as a new network goes, so that there is something to learn.
    wanted = np.tanh(10 * played(shown))
    learn = jax.jit(lambda: cloned(start, observations, jnp.asarray(wanted), jax.random.key(3), steps=1500, episodes=8))
    before, after = (np.mean((played(policy) - wanted) ** 2) for policy in (start, learn()))
    assert after < 0.05 * before


def test_a_step_takes_no_more_episodes_than_there_are() -> None:
    start = PolicyNetwork.create(3, 2, 8, jax.random.key(1))
    observations = jax.random.normal(jax.random.key(2), (2, HORIZON, 3), jnp.float32)
    actions = jnp.zeros((2, HORIZON, 2), jnp.float32)
    few, many = (
        cloned(start, observations, actions, jax.random.key(3), steps=3, episodes=episodes) for episodes in (2, 8)
    )
    for one, other in zip(jax.tree.leaves(few), jax.tree.leaves(many), strict=True):
        np.testing.assert_array_equal(one, other)
