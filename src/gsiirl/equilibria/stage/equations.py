"""The equations of a stage game's logit equilibrium.

With payoffs Q_l, Q_e, temperature τ and λ = 1/τ, log-policies u = ln π_l, v = ln π_e solve

    R_l(u, v; λ) = u − log_softmax(λ E_{π_e} Q_l) = 0,      R_e(u, v; λ) = v − log_softmax(λ E_{π_l} Q_e) = 0.

Actions that may not be chosen (`allowed` False) have the log-probability `FORBIDDEN`, so large that no step changes it.
Their probability is zero, so that they drop out of the equations of the other actions.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from gsiirl.games.base import FORBIDDEN
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides

Allowed = Sides[Bool[Array, " A"] | None]
"""Which actions each side may choose; None for all."""
ALL: Allowed = Sides(None, None)


def best_response(
    payoffs: Sides[AbstractPayoff], policies: Sides, inverse_temperature: Float[Array, ""], allowed: Allowed
) -> Sides:
    """Log-policies log_softmax(λ E Q) that answer the other side's policies."""
    values = Sides(
        inverse_temperature * payoffs.learner.learner_values(policies.expert),
        inverse_temperature * payoffs.expert.expert_values(policies.learner),
    )
    return jax.tree.map(jax.nn.log_softmax, where_allowed(allowed, values, FORBIDDEN))


def residual_of(
    payoffs: Sides[AbstractPayoff], log_policies: Sides, inverse_temperature: Float[Array, ""], allowed: Allowed
) -> Sides:
    """R_l and R_e at log-policies and λ."""
    policies = jax.tree.map(jnp.exp, log_policies)
    return jax.tree.map(jnp.subtract, log_policies, best_response(payoffs, policies, inverse_temperature, allowed))


def masked(allowed: Allowed) -> bool:
    """Whether any action of either side may not be chosen."""
    return allowed.learner is not None or allowed.expert is not None


def where_allowed(allowed: Allowed, values: Sides, otherwise: float) -> Sides:
    """`values` (..., A) of both sides, with another number for the actions that may not be chosen."""

    def of_one(mask: Array | None, values: Array) -> Array:
        return values if mask is None else jnp.where(jnp.broadcast_to(mask, values.shape), values, otherwise)

    return Sides(of_one(allowed.learner, values.learner), of_one(allowed.expert, values.expert))


def largest(residual: Sides) -> Float[Array, ""]:
    """max |R| over both sides."""
    return jnp.maximum(jnp.max(jnp.abs(residual.learner)), jnp.max(jnp.abs(residual.expert)))


def normalised(log_policies: Sides) -> Sides:
    """Log-policies whose probabilities sum to 1."""
    return jax.tree.map(jax.nn.log_softmax, log_policies)
