"""Putting ∇f together from its factors."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.hypergradients.linear_solve import BallConstraint, LinearSolution
from gsiirl.hypergradients.problem import Hypergradient


def without_response(
    through_learner: Float[Array, " n"], *, evaluations: int = 0, derivatives: int = 0
) -> Hypergradient:
    """∇f = ∇_{θ_l} f."""
    dtype = through_learner.dtype
    return Hypergradient(
        value=through_learner,
        through_learner=through_learner,
        through_expert=jnp.zeros_like(through_learner),
        evaluations=jnp.asarray(evaluations),
        derivatives=jnp.asarray(derivatives),
        upper_evaluations=jnp.asarray(0),
        linear_residual=jnp.zeros((), dtype),
        smallest_eigenvalue=jnp.asarray(jnp.inf, dtype),
        constrained=jnp.asarray(False),
    )


def with_response(
    through_learner: Float[Array, " n"],
    mixed_product: Float[Array, " n"],
    solved: LinearSolution,
    constraint: BallConstraint,
    *,
    evaluations: int | Array = 0,
    derivatives: int = 0,
    upper_evaluations: int = 0,
) -> Hypergradient:
    """∇f = ∇_{θ_l} f − Mᵀ w; `mixed_product` is Mᵀ w for the w of `solved`."""
    return Hypergradient(
        value=through_learner - mixed_product,
        through_learner=through_learner,
        through_expert=-mixed_product,
        evaluations=jnp.asarray(evaluations),
        derivatives=jnp.asarray(derivatives),
        upper_evaluations=jnp.asarray(upper_evaluations),
        linear_residual=solved.residual,
        smallest_eigenvalue=solved.smallest_eigenvalue,
        constrained=constraint.active,
    )
