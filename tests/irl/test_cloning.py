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


def test_a_clone_of_itself_stays_as_it_is() -> None:
    start = PolicyNetwork.create(3, 2, 8, jax.random.key(1))
    observations = jax.random.normal(jax.random.key(2), (2, HORIZON, 3), jnp.float32)
    times = jnp.arange(HORIZON, dtype=jnp.float32) / HORIZON
    actions = jax.vmap(jax.vmap(start), (0, None))(observations, times)
    # More episodes are asked for than there are.
    found = cloned(start, observations, actions, jax.random.key(3), steps=3, episodes=8)
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(start), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-2)
