"""What a policy looks like from its trajectories."""

import jax.numpy as jnp
from jaxtyping import Array, Float, Int


def estimated_policy(
    states: Int[Array, "d T"], actions: Int[Array, "d T"], prior: Float[Array, "T S A"]
) -> Float[Array, "T S A"]:
    """π̂_t(a|s) = (n_t(s, a) + prior_t(a|s)) / (n_t(s) + 1), from the counts n over d trajectories.

    The prior counts as one visit: it stands where nothing was seen.
    """
    steps = jnp.broadcast_to(jnp.arange(states.shape[1], dtype=states.dtype)[None, :], states.shape)
    counts = prior.at[steps, states, actions].add(1.0)
    return counts / jnp.sum(counts, axis=-1, keepdims=True)
