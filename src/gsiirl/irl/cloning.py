"""Behaviour cloning: the policy network that does what was demonstrated."""

from typing import Any

import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.equilibria.policy_network import PolicyNetwork

RATE, LAST_RATE = 3e-3, 0.02
"""Adam's first rate, and what it falls to, of the first."""


def cloned(
    start: PolicyNetwork,
    observations: Float[Array, "d T o"],
    actions: Float[Array, "d T A"],
    key: PRNGKeyArray,
    *,
    steps: int,
    episodes: int,
) -> PolicyNetwork:
    """The network after `steps` steps of Adam from `start` on the mean squared error of its actions.

        min_π (1/dT) Σ_i Σ_t ‖π(o_it, t/T) − a_it‖²

    A step takes `episodes` of the d episodes, drawn anew; its rate falls from `RATE` along half a cosine.
    """
    number, horizon = observations.shape[:2]
    times = jnp.arange(horizon, dtype=jnp.float32) / horizon
    optimiser = optax.adam(optax.cosine_decay_schedule(RATE, steps, LAST_RATE))

    def error(policy: PolicyNetwork, chosen: Array) -> Array:
        done = jax.vmap(jax.vmap(policy), (0, None))(observations[chosen], times)
        return jnp.mean((done - actions[chosen]) ** 2)

    def one_step(carry: tuple[Any, optax.OptState], key: PRNGKeyArray) -> tuple[tuple[Any, optax.OptState], None]:
        policy, remembered = carry
        chosen = jax.random.choice(key, number, (min(episodes, number),), replace=False)
        step, remembered = optimiser.update(jax.grad(error)(policy, chosen), remembered, policy)
        return (optax.apply_updates(policy, step), remembered), None

    beginning: Any = start
    return jax.lax.scan(one_step, (beginning, optimiser.init(beginning)), jax.random.split(key, steps))[0][0]
