"""The principal branch of a stage game's logit equilibria, followed from λ = 0 up to a target (Turocy 2005).

Pseudo-arclength continuation: a step along the tangent, then a corrector at right angles to it.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from gsiirl.equilibria.stage.equations import Allowed, largest, masked, normalised, residual_of, where_allowed
from gsiirl.games.base import FORBIDDEN
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides

BRANCH_STEPS = 2000
"""Most steps along a branch."""
CORRECTOR_STEPS = 3
"""Newton steps that bring a predicted point back to the branch."""
LARGEST_STEP, SMALLEST_STEP = 8.0, 1e-7
"""Bounds on the length of a step along the branch."""
LEAST_COSINE = 0.95
"""Cosine of the angle between the tangents before and after a step, below which it is taken again, shorter."""
LARGEST_MISS = 0.2
"""Most that the corrector may move a point, in lengths of the step."""
CORRECTED = 1e-5
"""Largest residual of a point on the branch."""
LEAST_FOLD = 1e-3
"""Length of a step below which a fold inside it is no longer looked for."""


class _Point(eqx.Module):
    """Log-policies and λ."""

    log_policies: Sides
    inverse_temperature: Float[Array, ""]


class Branch(eqx.Module):
    """How far a branch has been followed: the point, the tangent there, and the length of the next step."""

    point: _Point
    tangent: _Point
    length: Float[Array, ""]
    arrived: Bool[Array, ""]
    folds: Bool[Array, ""]
    steps: Int[Array, ""]


def _dot(a: _Point, b: _Point) -> Float[Array, ""]:
    return (
        jnp.sum(a.log_policies.learner * b.log_policies.learner)
        + jnp.sum(a.log_policies.expert * b.log_policies.expert)
        + a.inverse_temperature * b.inverse_temperature
    )


def _bordered_step(
    payoffs: Sides[AbstractPayoff],
    point: _Point,
    residual: Sides,
    row: _Point,
    row_target: Float[Array, ""],
    allowed: Allowed,
) -> tuple[_Point, Float[Array, ""]]:
    """Solve J w + ∂R/∂λ ℓ = −R, row·(w, ℓ) = row_target, with w keeping the policies normalised.

    Unlike J alone, the bordered system stays regular where the branch folds. The sign of its determinant comes with
    (w, ℓ).
    """
    policies = jax.tree.map(jnp.exp, point.log_policies)
    one_l, one_e = jnp.ones_like(residual.learner), jnp.ones_like(residual.expert)
    zero_l, zero_e = jnp.zeros_like(one_l), jnp.zeros_like(one_e)
    values = Sides(payoffs.learner.learner_values(policies.expert), payoffs.expert.expert_values(policies.learner))
    columns = payoffs.learner.solve_coupled(
        payoffs.expert,
        policies,
        point.inverse_temperature,
        Sides(
            jnp.stack([-residual.learner, -one_l, zero_l, values.learner]),
            jnp.stack([-residual.expert, zero_e, -one_e, values.expert]),
        ),
    )
    columns = where_allowed(allowed, columns, 0.0)
    on_learner = jnp.sum(columns.learner * policies.learner[None, :], axis=1)
    on_expert = jnp.sum(columns.expert * policies.expert[None, :], axis=1)
    on_row = jnp.sum(columns.learner * row.log_policies.learner[None, :], axis=1) + jnp.sum(
        columns.expert * row.log_policies.expert[None, :], axis=1
    )
    last = jnp.stack([on_row[1], on_row[2], on_row[3] + row.inverse_temperature])
    (kappa_l, kappa_e, step), determinant = _solve_3x3(
        jnp.stack([on_learner[1:], on_expert[1:], last]),
        jnp.stack([-on_learner[0], -on_expert[0], row_target - on_row[0]]),
    )
    moved = jax.tree.map(lambda c: c[0] + kappa_l * c[1] + kappa_e * c[2] + step * c[3], columns)
    sign = payoffs.learner.coupled_sign(payoffs.expert, policies, point.inverse_temperature) * jnp.sign(determinant)
    return _Point(moved, step), sign


def _solve_3x3(matrix: Float[Array, "3 3"], right: Float[Array, " 3"]) -> tuple[tuple[Array, Array, Array], Array]:
    """The solution and the determinant by Cramer's rule: elementwise, so that a batch of them stays one fused loop."""
    a, b, c = matrix[:, 0], matrix[:, 1], matrix[:, 2]
    bc, ca, ab = jnp.cross(b, c), jnp.cross(c, a), jnp.cross(a, b)
    determinant = jnp.sum(a * bc)
    solution = jnp.sum(right * bc) / determinant, jnp.sum(right * ca) / determinant, jnp.sum(right * ab) / determinant
    return solution, determinant


def follow_branch(
    payoffs: Sides[AbstractPayoff], target: Float[Array, ""], wanted: Bool[Array, ""], allowed: Allowed
) -> Branch:
    """Follow the principal branch from λ = 0 to its first crossing of `target`."""
    zero = jnp.zeros_like(target)
    origin = _Point(uniform_like(payoffs, allowed), zero)
    nothing = jax.tree.map(jnp.zeros_like, origin.log_policies)
    # At λ = 0 both play uniformly whatever the other does: d ln π_i / dλ is the action value less its mean.
    uniform = jax.tree.map(jnp.exp, origin.log_policies)
    values = Sides(payoffs.learner.learner_values(uniform.expert), payoffs.expert.expert_values(uniform.learner))
    means = jax.tree.map(jnp.mean, values) if not masked(allowed) else jax.tree.map(jnp.vdot, uniform, values)
    rising = where_allowed(allowed, jax.tree.map(jnp.subtract, values, means), 0.0)
    tangent = _unit(_Point(rising, zero + 1.0))

    def unfinished(branch: Branch) -> Bool[Array, ""]:
        return wanted & ~branch.arrived & (branch.steps < BRANCH_STEPS) & (branch.length > SMALLEST_STEP)

    def body(branch: Branch) -> Branch:
        point, tangent = branch.point, branch.tangent
        to_target = (target - point.inverse_temperature) / tangent.inverse_temperature
        crosses = (tangent.inverse_temperature > 0) & (to_target <= branch.length)
        length = jnp.where(crosses, to_target, branch.length)
        predicted = jax.tree.map(lambda w, d: w + length * d, point, tangent)
        # At the target λ is held fixed; elsewhere the corrector moves at right angles to the tangent.
        level = _Point(nothing, zero + 1.0)
        row = jax.tree.map(lambda a, b: jnp.where(crosses, a, b), level, tangent)
        corrected = _Point(normalised(predicted.log_policies), predicted.inverse_temperature)
        for _ in range(CORRECTOR_STEPS):
            residual = residual_of(payoffs, corrected.log_policies, corrected.inverse_temperature, allowed)
            off = _dot(row, jax.tree.map(jnp.subtract, predicted, corrected))
            step, _ = _bordered_step(payoffs, corrected, residual, row, off, allowed)
            moved = jax.tree.map(jnp.add, corrected, step)
            corrected = _Point(normalised(moved.log_policies), moved.inverse_temperature)
        left = largest(residual_of(payoffs, corrected.log_policies, corrected.inverse_temperature, allowed))
        turned, orientation = _bordered_step(payoffs, corrected, nothing, tangent, zero + 1.0, allowed)
        turned = _unit(turned)
        # A step that turns much, or that the corrector moves far, may have landed on another branch. So has one after
        # which the determinant's sign is another: it is the same all along a branch, and differs between two branches
        # that run side by side where they nearly meet.
        cosine = _dot(turned, tangent)
        missed = jax.tree.map(jnp.subtract, predicted, corrected)
        miss = jnp.sqrt(_dot(missed, missed)) / length
        same_branch = (cosine > LEAST_COSINE) & (miss < LARGEST_MISS) & (orientation > 0)
        risen = corrected.inverse_temperature - point.inverse_temperature
        hidden = (length > LEAST_FOLD) & turns_within(
            tangent.inverse_temperature, turned.inverse_temperature, risen / length
        )
        accepted = (left < CORRECTED) & same_branch & ~hidden

        def choose(new, old):
            return jax.tree.map(lambda a, b: jnp.where(accepted, a, b), new, old)

        grown = jnp.where((cosine > 0.99) & (miss < 0.05), 2.0, 1.0) * length
        return Branch(
            point=choose(corrected, point),
            tangent=choose(turned, tangent),
            length=jnp.minimum(jnp.where(accepted, grown, 0.5 * length), LARGEST_STEP),
            arrived=branch.arrived | (accepted & crosses),
            folds=branch.folds | (accepted & ~crosses & (turned.inverse_temperature < 0)),
            steps=branch.steps + 1,
        )

    start = Branch(
        point=origin,
        tangent=tangent,
        length=zero + 0.1,
        arrived=jnp.asarray(False),
        folds=jnp.asarray(False),
        steps=jnp.zeros((), jnp.int32),
    )
    return jax.lax.while_loop(unfinished, body, start)


def turns_within(first: Float[Array, ""], last: Float[Array, ""], mean: Float[Array, ""]) -> Bool[Array, ""]:
    """Whether λ turns back and forth within a step, by the cubic with these slopes at its ends and in the mean.

    With slopes of one sign at both ends the turns would go unseen.
    """
    sign = jnp.sign(first)
    first, last, mean = sign * first, sign * last, sign * mean
    # The cubic's slope is first − 2 s t + 3 c t² over t in [0, 1].
    slope, curvature = 2.0 * first + last - 3.0 * mean, first + last - 2.0 * mean
    dips_inside = (slope > 0) & (slope < 3.0 * curvature)
    return (last > 0) & dips_inside & (3.0 * curvature * first < slope**2)


def _unit(tangent: _Point) -> _Point:
    norm = jnp.sqrt(_dot(tangent, tangent))
    return jax.tree.map(lambda leaf: leaf / norm, tangent)


def uniform_like(payoffs: Sides[AbstractPayoff], allowed: Allowed) -> Sides:
    """Log-policies that choose all allowed actions alike."""
    learner_actions, expert_actions = payoffs.learner.number_of_actions
    dtype = jax.tree.leaves(payoffs)[0].dtype
    if not masked(allowed):
        return Sides(
            jnp.full(learner_actions, -jnp.log(learner_actions), dtype),
            jnp.full(expert_actions, -jnp.log(expert_actions), dtype),
        )
    nothing = Sides(jnp.zeros(learner_actions, dtype), jnp.zeros(expert_actions, dtype))
    return normalised(where_allowed(allowed, nothing, FORBIDDEN))
