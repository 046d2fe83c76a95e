"""Spearman's correlation of two tables: that of their ranks, which only asks whether the order of rewards is right."""

import jax.numpy as jnp
from jaxtyping import Array, Float

TIED = 1e-9
"""Values nearer to each other than this share of the table's range are tied."""


def spearman(first: Float[Array, "*n"], second: Float[Array, "*n"]) -> Float[Array, ""]:
    """Correlation of the ranks of all entries, tied ones sharing the mean of theirs; 0 where a table is constant."""
    one, other = _ranks(first.ravel()), _ranks(second.ravel())
    size = jnp.linalg.norm(one) * jnp.linalg.norm(other)
    return jnp.where(size > 0, jnp.vdot(one, other) / jnp.where(size > 0, size, 1.0), 0.0)


def _ranks(values: Float[Array, " n"]) -> Float[Array, " n"]:
    """Ranks less their mean."""
    span = jnp.max(values) - jnp.min(values)
    rounded = jnp.round((values - jnp.min(values)) / jnp.where(span > 0, TIED * span, 1.0))
    ordered = jnp.sort(rounded)
    before, upto = (jnp.searchsorted(ordered, rounded, side=side) for side in ("left", "right"))
    return 0.5 * (before + upto).astype(values.dtype) - 0.5 * values.size
