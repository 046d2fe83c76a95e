"""The lower level: projected gradient steps on θ_e (Algorithm 1, lines 5-8)."""

from collections.abc import Callable
from functools import cache
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, Int

Steps = Callable[[Int[Array, ""]], int | Array]
"""The number of inner steps t_k of outer iteration k ≥ 0."""


class MaximumLikelihood(eqx.Module):
    """θ_e ← Proj(θ_e + step), t_k times from a warm start, with steps that `optimiser` makes of τ∇L.

    The projection is to the closed unit ball, or with `on_sphere` to its surface. Plain gradient steps of size β are
    `optax.sgd(β)`.
    """

    temperature: float
    steps: Steps = eqx.field(static=True)
    optimiser: optax.GradientTransformation = eqx.field(static=True)
    on_sphere: bool = eqx.field(static=True, default=False)

    def fit(
        self,
        gradient: Callable[[Array], Array],
        parameters: Float[Array, " m"],
        optimiser_state: optax.OptState,
        iteration: Int[Array, ""],
    ) -> tuple[Float[Array, " m"], optax.OptState]:
        """θ_e and the optimiser's state after the steps of outer iteration k, along `gradient`(θ_e) = ∇L."""

        def one_step(_: Array, carry: tuple[Array, optax.OptState]) -> tuple[Array, optax.OptState]:
            return self.step(gradient(carry[0]), *carry)

        return jax.lax.fori_loop(0, self.steps(iteration), one_step, (parameters, optimiser_state))

    def step(
        self, gradient: Float[Array, " m"], parameters: Float[Array, " m"], optimiser_state: optax.OptState
    ) -> tuple[Float[Array, " m"], optax.OptState]:
        """One projected step along `gradient` = ∇L; on the sphere along its part across θ_e."""
        gradient = across(gradient, parameters) if self.on_sphere else gradient
        step, optimiser_state = self.optimiser.update(self.temperature * gradient, optimiser_state, parameters)
        stepped: Any = optax.apply_updates(parameters, step)
        return self.projected(stepped), optimiser_state

    def projected(self, parameters: Float[Array, " m"]) -> Float[Array, " m"]:
        """Onto the unit ball, or its surface."""
        project = optax.projections.projection_l2_sphere if self.on_sphere else optax.projections.projection_l2_ball
        return project(parameters, 1.0)


def across(gradient: Float[Array, " m"], parameters: Float[Array, " m"]) -> Float[Array, " m"]:
    """The part of a gradient across the parameters: g − (g·θ / θ·θ) θ.

    The part along them changes their length alone, which a projection to the sphere takes back. Yet Adam would scale
    its steps by it, entry by entry, and so turn them.
    """
    return gradient - jnp.vdot(gradient, parameters) / jnp.vdot(parameters, parameters) * parameters


@cache
def constant_steps(number: int, first: int | None = None) -> Steps:
    """As many inner steps in every outer iteration, or `first` in the first one."""
    if first is None:
        return lambda iteration: number
    return lambda iteration: jnp.where(iteration == 0, first, number)


def growing_steps(iteration: Int[Array, ""]) -> Int[Array, ""]:
    """The paper's t_k = ⌈(k + 1)^(1/4) / 2⌉ (Theorem 2): 1 up to k = 15, 2 up to k = 255."""
    # In integers: t_k is the least t with 16 t⁴ ≥ k + 1.
    candidates = jnp.arange(1, 65, dtype=iteration.dtype)
    return 1 + jnp.sum(16 * candidates**4 < iteration + 1, dtype=iteration.dtype)
