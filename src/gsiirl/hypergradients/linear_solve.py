"""The linear system of Lemma 2, inside the unit ball and on its sphere.

Inside, w = H⁻¹ b. On the sphere (‖θ_e‖ = 1 with multiplier ν = −θ_e·∇_{θ_e} L > 0) only tangential directions count:

    w = P (P (H + νI) P)⁺ P b,     P = I − θ_e θ_eᵀ
"""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int


class BallConstraint(eqx.Module):
    """The closed unit ball at a point: `normal` θ_e/‖θ_e‖, `multiplier` ν (0 inside), and whether it is `active`."""

    normal: Float[Array, " m"]
    multiplier: Float[Array, ""]
    active: Bool[Array, ""]

    @classmethod
    def at(cls, point: Float[Array, " m"], gradient: Float[Array, " m"]) -> "BallConstraint":
        """Active where the point lies on the sphere, to half the digits, and −∇L points outwards."""
        norm = jnp.linalg.norm(point)
        multiplier = -jnp.vdot(point, gradient)
        on_sphere = norm >= 1.0 - jnp.sqrt(jnp.finfo(point.dtype).eps)
        active = on_sphere & (multiplier > 0.0)
        normal = point / jnp.where(norm > 0.0, norm, 1.0)
        return cls(normal, jnp.where(active, multiplier, 0.0), active)

    def project(self, vector: Float[Array, " m"]) -> Float[Array, " m"]:
        """P v on the sphere, v inside."""
        return vector - jnp.where(self.active, jnp.vdot(self.normal, vector), 0.0) * self.normal


class LinearSolution(eqx.Module):
    """w with its relative residual, the smallest eigenvalue met of the symmetric part, and products with H used."""

    solution: Float[Array, " m"]
    residual: Float[Array, ""]
    smallest_eigenvalue: Float[Array, ""]
    products: Int[Array, ""]


def solve_dense(
    hessian: Float[Array, "m m"], right_hand_side: Float[Array, " m"], constraint: BallConstraint
) -> LinearSolution:
    """w for any nonsingular H, symmetric or not, by elimination."""
    size, dtype = right_hand_side.shape[0], right_hand_side.dtype
    identity = jnp.eye(size, dtype=dtype)
    outwards = jnp.outer(constraint.normal, constraint.normal) * constraint.active.astype(dtype)
    projection = identity - outwards
    tangential = projection @ (hessian + constraint.multiplier * identity) @ projection
    wanted = constraint.project(right_hand_side)
    # The normal direction is given the eigenvalue of a large number, so that it is neither singular nor the smallest.
    system = tangential + (1.0 + jnp.linalg.norm(tangential)) * outwards
    solution = constraint.project(jnp.linalg.solve(system, wanted))
    return LinearSolution(
        solution,
        _relative(tangential @ solution - wanted, wanted),
        jnp.linalg.eigvalsh(0.5 * (system + system.T))[0],
        jnp.asarray(0),
    )


def conjugate_gradients(
    product: Callable[[Array], Array],
    right_hand_side: Float[Array, " m"],
    constraint: BallConstraint,
    tolerance: float,
    iterations: int,
) -> LinearSolution:
    """w for a symmetric H known by its products H v alone; stops at `tolerance`, or where curvature is not positive.

    `smallest_eigenvalue` is the smallest vᵀ(H + νI)v / vᵀv over the directions taken: an upper bound.
    """
    wanted = constraint.project(right_hand_side)
    threshold = tolerance * jnp.linalg.norm(wanted)

    def unfinished(carry):
        _, residual, _, smallest, used = carry
        return (jnp.linalg.norm(residual) > threshold) & (smallest > 0.0) & (used < iterations)

    def step(carry):
        solution, residual, direction, smallest, used = carry
        applied = constraint.project(product(direction) + constraint.multiplier * direction)
        curvature = jnp.vdot(direction, applied)
        quotient = curvature / jnp.vdot(direction, direction)
        length = jnp.vdot(residual, residual)
        # Along a direction without positive curvature there is no minimum: stay where we are.
        rate = jnp.where(curvature > 0.0, length / curvature, 0.0)
        following = constraint.project(residual - rate * applied)
        turned = following + jnp.vdot(following, following) / length * direction
        return solution + rate * direction, following, turned, jnp.minimum(smallest, quotient), used + 1

    nothing = jnp.zeros_like(wanted)
    start = (nothing, wanted, wanted, jnp.asarray(jnp.inf, wanted.dtype), jnp.asarray(0))
    solution, residual, _, smallest, used = jax.lax.while_loop(unfinished, step, start)
    return LinearSolution(solution, _relative(residual, wanted), smallest, used)


def _relative(residual: Float[Array, " m"], wanted: Float[Array, " m"]) -> Float[Array, ""]:
    size = jnp.linalg.norm(wanted)
    return jnp.linalg.norm(residual) / jnp.where(size > 0.0, size, 1.0)
