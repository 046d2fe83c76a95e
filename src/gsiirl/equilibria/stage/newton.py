"""Damped Newton's method for the equations of a stage game."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from gsiirl.equilibria.stage.equations import Allowed, largest, normalised, residual_of
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides

NEWTON_STEPS = 60
"""Most steps of Newton's method."""


def newton_direction(
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


class Newton(eqx.Module):
    """Where Newton's method is: log-policies, their residual with its largest entry, and the next step's length."""

    log_policies: Sides
    residual: Sides
    length: Float[Array, ""]
    size: Float[Array, ""]
    steps: Int[Array, ""]


def newton(
    payoffs: Sides[AbstractPayoff],
    inverse_temperature: Float[Array, ""],
    start: Sides,
    tolerance: float | Float[Array, ""],
    wanted: Bool[Array, ""],
    allowed: Allowed,
) -> Newton:
    """Newton's method with step halving on max |R|; stops at `tolerance`, or where no step helps any more."""
    residual = residual_of(payoffs, start, inverse_temperature, allowed)
    one = jnp.ones_like(largest(residual))

    def unfinished(state: Newton) -> Bool[Array, ""]:
        return wanted & (state.size > tolerance) & (state.steps < NEWTON_STEPS) & (state.length > 1e-6)

    def body(state: Newton) -> Newton:
        direction = newton_direction(payoffs, state.log_policies, inverse_temperature, state.residual)
        trial = normalised(jax.tree.map(lambda w, d: w + state.length * d, state.log_policies, direction))
        residual = residual_of(payoffs, trial, inverse_temperature, allowed)
        size = largest(residual)
        accepted = size < (1.0 - 1e-3 * state.length) * state.size

        def choose(new, old):
            return jax.tree.map(lambda a, b: jnp.where(accepted, a, b), new, old)

        return Newton(
            log_policies=choose(trial, state.log_policies),
            residual=choose(residual, state.residual),
            length=jnp.where(accepted, one, 0.5 * state.length),
            size=choose(size, state.size),
            steps=state.steps + 1,
        )

    initial = Newton(start, residual, one, largest(residual), jnp.zeros((), jnp.int32))
    return jax.lax.while_loop(unfinished, body, initial)
