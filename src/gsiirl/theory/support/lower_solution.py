"""θ_e* to rounding: the root of G = ∇_{θ_e} L in the unit ball, or its projected form on the sphere.

θ is a solution where the natural residual vanishes (for a convex L these are the minimisers over the ball):

    R(θ) = (θ − Proj(z)) / t,     z = θ − t G(θ)

R = G where z lies in the ball, so that Newton's step for R is that for G there, and that of the conditions of Karush,
Kuhn and Tucker on the sphere.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from gsiirl.hypergradients.linear_solve import BallConstraint

TOLERANCE = 1e-14
ITERATIONS = 60
HALVINGS = 6
PATIENCE = 6


class LowerSolution(eqx.Module):
    """θ_e* with the norm ‖R‖ of the projected gradient there, and the ball's part in it.

    `constraint` has the multiplier ν = −θ_e·G, and whether the ball is active.
    """

    parameters: Float[Array, " m"]
    residual: Float[Array, ""]
    constraint: BallConstraint

    @property
    def active(self) -> Bool[Array, "..."]:
        """Whether θ_e* lies on the sphere, held there with ν > 0."""
        return self.constraint.active


def solve_lower(gradient: Callable[[Array], Array], start: Float[Array, " m"]) -> LowerSolution:
    """θ_e* for G = `gradient`, which `jax.jacfwd` can differentiate; `start` is brought into the ball.

    An iteration takes the best of the projected gradient step and of Newton's step in lengths 1, 1/2, 1/4, …; where
    none of them lowers ‖R‖, t is cut. It ends where cutting t no longer helps, which is at rounding, or far from any
    solution where L is all kinks; `residual` tells.
    """
    lengths = 0.5 ** jnp.arange(HALVINGS, dtype=start.dtype)
    identity = jnp.eye(start.shape[0], dtype=start.dtype)

    def with_value(theta: Array) -> tuple[Array, Array]:
        value = gradient(theta)
        return value, value

    def size(theta: Array, slope: Array, step: Array) -> Array:
        return jnp.linalg.norm(theta - _into_ball(theta - step * slope)) / step

    def unfinished(carry: tuple) -> Array:
        _, _, current, _, failures, used = carry
        return (current > TOLERANCE) & (failures < PATIENCE) & (used < ITERATIONS)

    def iterate(carry: tuple) -> tuple:
        theta, _, _, step, failures, used = carry
        hessian, slope = jax.jacfwd(with_value, has_aux=True)(theta)
        # The curvature at the start stands for the smoothness of L.
        step = jnp.where(used == 0, 1.0 / jnp.linalg.norm(hessian), step)
        current = size(theta, slope, step)
        moved, jacobian = theta - step * slope, identity - step * hessian
        norm = jnp.linalg.norm(moved)
        # d Proj(z) / dθ.
        outwards = jnp.outer(moved, moved) / norm**2
        jacobian = jnp.where(norm > 1.0, (identity - outwards) @ jacobian / norm, jacobian)
        newton = jnp.linalg.solve(identity - jacobian, _into_ball(moved) - theta)
        steps = jnp.concatenate([moved[None, :], theta[None, :] + lengths[:, None] * newton[None, :]])
        points = jax.vmap(_into_ball)(steps)
        slopes = jax.vmap(gradient)(points)
        sizes = jax.vmap(size, (0, 0, None))(points, slopes, step)
        best = jnp.nanargmin(sizes)
        better = sizes[best] < current
        return (
            jnp.where(better, points[best], theta),
            jnp.where(better, slopes[best], slope),
            jnp.where(better, sizes[best], current),
            jnp.where(better, step, step / 10.0),
            jnp.where(better, 0, failures + 1),
            used + 1,
        )

    unknown = jnp.asarray(jnp.inf, start.dtype)
    first = (_into_ball(start), jnp.zeros_like(start), unknown, unknown, jnp.asarray(0), jnp.asarray(0))
    theta, slope, residual, *_ = jax.lax.while_loop(unfinished, iterate, first)
    return LowerSolution(theta, residual, BallConstraint.at(theta, slope))


def _into_ball(point: Float[Array, " m"]) -> Float[Array, " m"]:
    return point / jnp.maximum(1.0, jnp.linalg.norm(point))
