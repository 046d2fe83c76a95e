"""A test that proves of some stage games that they have one logit equilibrium."""

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from gsiirl.games.payoff import AbstractPayoff, MatchingPayoff
from gsiirl.types import Sides


def certified_unique(payoffs: Sides[AbstractPayoff], inverse_temperature: Float[Array, ""]) -> Bool[Array, ""]:
    """Whether the stage game provably has one logit equilibrium at λ; False means "not proved".

    For matching payoffs the Jacobian's determinant at an equilibrium is ∏_b D_b times that of a 2x2 Schur complement,
    with D = 1 − λ² z_l z_e π_l π_e. Both factors are positive at every equilibrium when, with upper bounds p̄, q̄ of the
    policies,

        λ² max_b (z_l⁺ q̄) max_b (z_e⁺ p̄) < 1    and    λ² max_b (z_l⁻ q̄) max_b (z_e⁻ p̄) < 1.

    Then every equilibrium has index +1, the indices sum to +1, and there is exactly one. The nearly zero-sum case
    (blocking helps the learner and hurts the expert) satisfies both with a zero on the left.
    """
    if not isinstance(payoffs.learner, MatchingPayoff) or not isinstance(payoffs.expert, MatchingPayoff):
        return jnp.asarray(False)
    z_learner, z_expert = payoffs.learner.match, payoffs.expert.match
    matches = z_learner.shape[0]
    p_bound = _policy_bound(inverse_temperature, payoffs.learner.learner, z_learner)[:matches]
    q_bound = _policy_bound(inverse_temperature, payoffs.expert.expert, z_expert)[:matches]
    positive = jnp.max(jnp.maximum(z_learner, 0) * q_bound) * jnp.max(jnp.maximum(z_expert, 0) * p_bound)
    negative = jnp.max(jnp.maximum(-z_learner, 0) * q_bound) * jnp.max(jnp.maximum(-z_expert, 0) * p_bound)
    return inverse_temperature**2 * jnp.maximum(positive, negative) < 0.99


def _policy_bound(
    inverse_temperature: Float[Array, ""], own: Float[Array, " A"], match: Float[Array, " M"]
) -> Float[Array, " A"]:
    """Upper bounds of softmax(λ (own + match·x)) over all x in [0, 1]."""
    gap = own.shape[0] - match.shape[0]
    least = inverse_temperature * (own + jnp.pad(jnp.minimum(match, 0), (0, gap)))
    most = inverse_temperature * (own + jnp.pad(jnp.maximum(match, 0), (0, gap)))
    shift = jnp.max(least)
    others = jnp.maximum(jnp.sum(jnp.exp(least - shift)) - jnp.exp(least - shift), 0.0)
    # exp of at most 0 wherever the bound is not simply close to one, so nothing overflows.
    odds = jnp.exp(jnp.minimum(most - shift, 500.0))
    return odds / (odds + others)
