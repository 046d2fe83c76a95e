"""The lower level: projected gradient steps on θ_e over the remembered interactions (Algorithm 1, lines 5-8)."""

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float

from gsiirl.games.base import AbstractTabularGame
from gsiirl.irl.likelihood import played_gradient
from gsiirl.irl.memory import Memory
from gsiirl.rewards.linear import Linear


class MaximumLikelihood(eqx.Module):
    """θ_e ← Proj(θ_e + step), `steps` times from a warm start, with steps that `optimiser` makes of τ∇L.

    ∇L is averaged over the memory; the projection is to the closed unit ball. Plain gradient steps of size β are
    `optax.sgd(β)`.
    """

    temperature: float
    discount: float
    regularisation: float
    steps: int = eqx.field(static=True)
    optimiser: optax.GradientTransformation = eqx.field(static=True)

    def gradient(
        self, game: AbstractTabularGame, reward: Linear, parameters: Float[Array, " m"], memory: Memory
    ) -> Float[Array, " m"]:
        """∇L averaged over the remembered interactions, (m,)."""
        gradients = jax.vmap(
            lambda policy, demonstrated: played_gradient(
                game,
                reward,
                parameters,
                policy,
                demonstrated,
                self.temperature,
                self.discount,
                self.regularisation,
            )
        )(memory.learner_policies, memory.demonstrated)
        return jnp.mean(gradients, axis=0, where=memory.filled[:, None])

    def fit(
        self,
        game: AbstractTabularGame,
        reward: Linear,
        parameters: Float[Array, " m"],
        optimiser_state: optax.OptState,
        memory: Memory,
    ) -> tuple[Float[Array, " m"], optax.OptState]:
        """θ_e and the optimiser's state after `steps` projected steps."""

        def one_step(_: Array, carry: tuple[Array, optax.OptState]) -> tuple[Array, optax.OptState]:
            theta, state = carry
            gradient = self.temperature * self.gradient(game, reward, theta, memory)
            step, state = self.optimiser.update(gradient, state, theta)
            return optax.projections.projection_l2_ball(optax.apply_updates(theta, step), 1.0), state

        return jax.lax.fori_loop(0, self.steps, one_step, (parameters, optimiser_state))
