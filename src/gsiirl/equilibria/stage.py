"""The logit equilibrium of one stage game, on the principal branch.

With payoffs Q_l, Q_e, temperature τ and λ = 1/τ, find log-policies u = ln π_l, v = ln π_e with

    R_l(u, v; λ) = u − log_softmax(λ E_{π_e} Q_l) = 0,      R_e(u, v; λ) = v − log_softmax(λ E_{π_l} Q_e) = 0.

Two methods share one linear system, solved by elimination of what couples pairs of actions (`solve_coupled`) and a
small border: two multipliers that keep the policies normalised and, along a path, the step in λ.

- `_newton`: damped Newton at the target λ. It is used alone only where `_certified_unique` proves that one equilibrium
  exists, so that it cannot find a wrong one.
- `_follow_branch`: pseudo-arclength continuation from the uniform policies at λ = 0 (Turocy 2005) up to the first
  crossing of the target λ; a branch that turns back on the way is flagged.

Actions that may not be chosen (`allowed` False) have the log-probability `FORBIDDEN`, so large that no step changes it.
Their probability is zero, so that they drop out of the equations of the other actions.

Every function takes one stage game; `vmap` is outside.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from gsiirl.games.base import FORBIDDEN
from gsiirl.games.payoff import AbstractPayoff, MatchingPayoff
from gsiirl.types import Sides

Allowed = Sides[Bool[Array, " A"] | None]
ALL: Allowed = Sides(None, None)

_NEWTON_STEPS = 60
_BRANCH_STEPS = 2000
_CORRECTOR_STEPS = 3
_LARGEST_STEP = 8.0
_SMALLEST_STEP = 1e-7
_LEAST_COSINE = 0.95
_LARGEST_MISS = 0.2
_CORRECTED = 1e-5
_LEAST_FOLD = 1e-3


class StageSolution(eqx.Module):
    """Log-policies of a stage game, with how they were found.

    `residual` is max |R| over both sides; `branch_folds` says that the principal branch turned back in λ before the
    target; `followed` that it was followed at all (not needed where the equilibrium is provably unique); `steps` counts
    Newton and continuation steps.
    """

    log_policies: Sides[Float[Array, " A"]]
    residual: Float[Array, ""]
    branch_folds: Bool[Array, ""]
    followed: Bool[Array, ""]
    steps: Int[Array, ""]


def solve_stage(
    payoffs: Sides[AbstractPayoff],
    temperature: Float[Array, ""],
    guess: Sides[Float[Array, " A"]],
    tolerance: float | Float[Array, ""],
    allowed: Allowed = ALL,
) -> StageSolution:
    """The principal logit equilibrium of one stage game; `guess` are log-policies to start Newton's method from.

    `allowed` says which actions each side may choose, None being all. Not differentiable: see
    `differentiable_log_policies`.
    """
    target = 1.0 / temperature
    start = _best_response(payoffs, jax.tree.map(jnp.exp, guess), target, allowed)
    certified = _certified_unique(payoffs, target) if not _masked(allowed) else jnp.asarray(False)
    tried = _newton(payoffs, target, start, tolerance, certified, allowed)
    unsolved = ~(certified & (tried.size <= tolerance))
    branch = _follow_branch(payoffs, target, unsolved, allowed)
    log_policies = jax.tree.map(lambda a, b: jnp.where(unsolved, a, b), branch.point.log_policies, tried.log_policies)
    polished = _newton(payoffs, target, log_policies, tolerance, unsolved, allowed)
    return StageSolution(
        log_policies=polished.log_policies,
        residual=jnp.where(unsolved & ~branch.arrived, jnp.inf, polished.size),
        branch_folds=branch.folds,
        followed=unsolved,
        steps=tried.steps + branch.steps + polished.steps,
    )


def differentiable_log_policies(
    payoffs: Sides[AbstractPayoff],
    temperature: Float[Array, ""],
    log_policies: Sides[Float[Array, " A"]],
    allowed: Allowed = ALL,
) -> Sides[Float[Array, " A"]]:
    """The solution as a function of payoffs and temperature, by the implicit function theorem.

    One Newton step from the solution w*: w* − J⁻¹ R(w*; payoffs, τ) with J and w* held fixed. Its value is w*, its
    first derivative is −J⁻¹ ∂R, in forward and in reverse mode.
    """
    frozen = jax.lax.stop_gradient(log_policies)
    residual = _residual(payoffs, frozen, 1.0 / temperature, allowed)
    held = jax.lax.stop_gradient(payoffs)
    step = _newton_direction(held, frozen, jax.lax.stop_gradient(1.0 / temperature), residual)
    return jax.tree.map(jnp.add, frozen, step)


def _best_response(
    payoffs: Sides[AbstractPayoff], policies: Sides, inverse_temperature: Float[Array, ""], allowed: Allowed
) -> Sides:
    values = Sides(
        inverse_temperature * payoffs.learner.learner_values(policies.expert),
        inverse_temperature * payoffs.expert.expert_values(policies.learner),
    )
    return jax.tree.map(jax.nn.log_softmax, _where_allowed(allowed, values, FORBIDDEN))


def _residual(
    payoffs: Sides[AbstractPayoff], log_policies: Sides, inverse_temperature: Float[Array, ""], allowed: Allowed
) -> Sides:
    policies = jax.tree.map(jnp.exp, log_policies)
    return jax.tree.map(jnp.subtract, log_policies, _best_response(payoffs, policies, inverse_temperature, allowed))


def _masked(allowed: Allowed) -> bool:
    return allowed.learner is not None or allowed.expert is not None


def _where_allowed(allowed: Allowed, values: Sides, otherwise: float) -> Sides:
    """`values` (..., A) of both sides, with another number for the actions that may not be chosen."""

    def of_one(mask: Array | None, values: Array) -> Array:
        return values if mask is None else jnp.where(jnp.broadcast_to(mask, values.shape), values, otherwise)

    return Sides(of_one(allowed.learner, values.learner), of_one(allowed.expert, values.expert))


def _size(residual: Sides) -> Float[Array, ""]:
    return jnp.maximum(jnp.max(jnp.abs(residual.learner)), jnp.max(jnp.abs(residual.expert)))


def _normalised(log_policies: Sides) -> Sides:
    return jax.tree.map(jax.nn.log_softmax, log_policies)


def _newton_direction(
    payoffs: Sides[AbstractPayoff],
    log_policies: Sides,
    inverse_temperature: Float[Array, ""],
    residual: Sides,
) -> Sides:
    """−J⁻¹ R among directions that keep both policies normalised (π_l·u = 0, π_e·v = 0)."""
    policies = jax.tree.map(jnp.exp, log_policies)
    one_l, one_e = jnp.ones_like(residual.learner), jnp.ones_like(residual.expert)
    zero_l, zero_e = jnp.zeros_like(one_l), jnp.zeros_like(one_e)
    columns = payoffs.learner.solve_coupled(
        payoffs.expert,
        policies,
        inverse_temperature,
        Sides(jnp.stack([-residual.learner, one_l, zero_l]), jnp.stack([-residual.expert, zero_e, one_e])),
    )
    # u = c₀ − κ_l c₁ − κ_e c₂ with the multipliers κ from normalisation.
    on_learner = jnp.sum(columns.learner * policies.learner[None, :], axis=1)
    on_expert = jnp.sum(columns.expert * policies.expert[None, :], axis=1)
    determinant = on_learner[1] * on_expert[2] - on_learner[2] * on_expert[1]
    kappa_l = (on_learner[0] * on_expert[2] - on_learner[2] * on_expert[0]) / determinant
    kappa_e = (on_learner[1] * on_expert[0] - on_learner[0] * on_expert[1]) / determinant
    return jax.tree.map(lambda c: c[0] - kappa_l * c[1] - kappa_e * c[2], columns)


class _Newton(eqx.Module):
    log_policies: Sides
    residual: Sides
    length: Float[Array, ""]
    size: Float[Array, ""]
    steps: Int[Array, ""]


def _newton(
    payoffs: Sides[AbstractPayoff],
    inverse_temperature: Float[Array, ""],
    start: Sides,
    tolerance: float | Float[Array, ""],
    wanted: Bool[Array, ""],
    allowed: Allowed,
) -> _Newton:
    """Newton's method with step halving on max |R|; stops at `tolerance`, or where no step helps any more."""
    residual = _residual(payoffs, start, inverse_temperature, allowed)
    one = jnp.ones_like(_size(residual))

    def unfinished(state: _Newton) -> Bool[Array, ""]:
        return wanted & (state.size > tolerance) & (state.steps < _NEWTON_STEPS) & (state.length > 1e-6)

    def body(state: _Newton) -> _Newton:
        direction = _newton_direction(payoffs, state.log_policies, inverse_temperature, state.residual)
        trial = _normalised(jax.tree.map(lambda w, d: w + state.length * d, state.log_policies, direction))
        residual = _residual(payoffs, trial, inverse_temperature, allowed)
        size = _size(residual)
        accepted = size < (1.0 - 1e-3 * state.length) * state.size

        def choose(new, old):
            return jax.tree.map(lambda a, b: jnp.where(accepted, a, b), new, old)

        return _Newton(
            log_policies=choose(trial, state.log_policies),
            residual=choose(residual, state.residual),
            length=jnp.where(accepted, one, 0.5 * state.length),
            size=choose(size, state.size),
            steps=state.steps + 1,
        )

    initial = _Newton(start, residual, one, _size(residual), jnp.zeros((), jnp.int32))
    return jax.lax.while_loop(unfinished, body, initial)


def _certified_unique(payoffs: Sides[AbstractPayoff], inverse_temperature: Float[Array, ""]) -> Bool[Array, ""]:
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


class _Point(eqx.Module):
    log_policies: Sides
    inverse_temperature: Float[Array, ""]


class _Branch(eqx.Module):
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
    columns = _where_allowed(allowed, columns, 0.0)
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


def _follow_branch(
    payoffs: Sides[AbstractPayoff], target: Float[Array, ""], wanted: Bool[Array, ""], allowed: Allowed
) -> _Branch:
    """Follow the principal branch from λ = 0 to its first crossing of `target`."""
    zero = jnp.zeros_like(target)
    origin = _Point(_uniform_like(payoffs, allowed), zero)
    nothing = jax.tree.map(jnp.zeros_like, origin.log_policies)
    # At λ = 0 both play uniformly whatever the other does: d ln π_i / dλ is the action value less its mean.
    uniform = jax.tree.map(jnp.exp, origin.log_policies)
    values = Sides(payoffs.learner.learner_values(uniform.expert), payoffs.expert.expert_values(uniform.learner))
    means = jax.tree.map(jnp.mean, values) if not _masked(allowed) else jax.tree.map(jnp.vdot, uniform, values)
    rising = _where_allowed(allowed, jax.tree.map(jnp.subtract, values, means), 0.0)
    tangent = _unit(_Point(rising, zero + 1.0))

    def unfinished(branch: _Branch) -> Bool[Array, ""]:
        return wanted & ~branch.arrived & (branch.steps < _BRANCH_STEPS) & (branch.length > _SMALLEST_STEP)

    def body(branch: _Branch) -> _Branch:
        point, tangent = branch.point, branch.tangent
        to_target = (target - point.inverse_temperature) / tangent.inverse_temperature
        crosses = (tangent.inverse_temperature > 0) & (to_target <= branch.length)
        length = jnp.where(crosses, to_target, branch.length)
        predicted = jax.tree.map(lambda w, d: w + length * d, point, tangent)
        # At the target λ is held fixed; elsewhere the corrector moves at right angles to the tangent.
        level = _Point(nothing, zero + 1.0)
        row = jax.tree.map(lambda a, b: jnp.where(crosses, a, b), level, tangent)
        corrected = _Point(_normalised(predicted.log_policies), predicted.inverse_temperature)
        for _ in range(_CORRECTOR_STEPS):
            residual = _residual(payoffs, corrected.log_policies, corrected.inverse_temperature, allowed)
            off = _dot(row, jax.tree.map(jnp.subtract, predicted, corrected))
            step, _ = _bordered_step(payoffs, corrected, residual, row, off, allowed)
            moved = jax.tree.map(jnp.add, corrected, step)
            corrected = _Point(_normalised(moved.log_policies), moved.inverse_temperature)
        left = _size(_residual(payoffs, corrected.log_policies, corrected.inverse_temperature, allowed))
        turned, orientation = _bordered_step(payoffs, corrected, nothing, tangent, zero + 1.0, allowed)
        turned = _unit(turned)
        # A step that turns much, or that the corrector moves far, may have landed on another branch. So has one after
        # which the determinant's sign is another: it is the same all along a branch, and differs between two branches
        # that run side by side where they nearly meet.
        cosine = _dot(turned, tangent)
        missed = jax.tree.map(jnp.subtract, predicted, corrected)
        miss = jnp.sqrt(_dot(missed, missed)) / length
        same_branch = (cosine > _LEAST_COSINE) & (miss < _LARGEST_MISS) & (orientation > 0)
        risen = corrected.inverse_temperature - point.inverse_temperature
        hidden = (length > _LEAST_FOLD) & _turns_within(
            tangent.inverse_temperature, turned.inverse_temperature, risen / length
        )
        accepted = (left < _CORRECTED) & same_branch & ~hidden

        def choose(new, old):
            return jax.tree.map(lambda a, b: jnp.where(accepted, a, b), new, old)

        grown = jnp.where((cosine > 0.99) & (miss < 0.05), 2.0, 1.0) * length
        return _Branch(
            point=choose(corrected, point),
            tangent=choose(turned, tangent),
            length=jnp.minimum(jnp.where(accepted, grown, 0.5 * length), _LARGEST_STEP),
            arrived=branch.arrived | (accepted & crosses),
            folds=branch.folds | (accepted & ~crosses & (turned.inverse_temperature < 0)),
            steps=branch.steps + 1,
        )

    start = _Branch(
        point=origin,
        tangent=tangent,
        length=zero + 0.1,
        arrived=jnp.asarray(False),
        folds=jnp.asarray(False),
        steps=jnp.zeros((), jnp.int32),
    )
    return jax.lax.while_loop(unfinished, body, start)


def _turns_within(first: Float[Array, ""], last: Float[Array, ""], mean: Float[Array, ""]) -> Bool[Array, ""]:
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


def _uniform_like(payoffs: Sides[AbstractPayoff], allowed: Allowed) -> Sides:
    learner_actions, expert_actions = payoffs.learner.number_of_actions
    dtype = jax.tree.leaves(payoffs)[0].dtype
    if not _masked(allowed):
        return Sides(
            jnp.full(learner_actions, -jnp.log(learner_actions), dtype),
            jnp.full(expert_actions, -jnp.log(expert_actions), dtype),
        )
    nothing = Sides(jnp.zeros(learner_actions, dtype), jnp.zeros(expert_actions, dtype))
    return _normalised(_where_allowed(allowed, nothing, FORBIDDEN))
