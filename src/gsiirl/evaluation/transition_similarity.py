"""How alike two rewards of a continuous game are, over sampled transitions."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import Transition


def pearson(first: TransitionReward, second: TransitionReward, sample: Transition) -> Float[Array, ""]:
    """Pearson correlation of two rewards over a sample of transitions (axis n); 0 where one of them is constant."""
    values = jnp.stack([jax.vmap(first)(sample), jax.vmap(second)(sample)])
    centred = values - jnp.mean(values, axis=1, keepdims=True)
    norms = jnp.linalg.norm(centred, axis=1)
    product = jnp.vdot(centred[0], centred[1])
    scale = norms[0] * norms[1]
    return jnp.where(scale > 0, product / jnp.where(scale > 0, scale, 1.0), 0.0)


def epic(correlation: Float[Array, ""]) -> Float[Array, ""]:
    """EPIC distance √((1 − ρ)/2) of two rewards that depend on (a, s') alone (Gleave et al. 2021).

    With S, A and S' independent, canonicalisation then only subtracts a constant, so that ρ is the correlation over
    independent a and s'.
    """
    return jnp.sqrt(jnp.maximum(1.0 - correlation, 0.0) / 2.0)
