"""The learner's expert-dependent reward, fitted to the values it reads where it has been."""

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float

from gsiirl.games.payoff import AbstractPayoff
from gsiirl.rewards.linear import Linear
from gsiirl.types import Sides, Trajectories


class LeastSquares(eqx.Module):
    """The normal equations of r^θ(s, a) ≈ r_ld(s, a) over everything visited: Σ ∇r ∇rᵀ and Σ ∇r r_ld."""

    gram: Float[Array, "n n"]
    moment: Float[Array, " n"]

    @classmethod
    def empty(cls, parameters: int, dtype: jnp.dtype) -> "LeastSquares":
        """Nothing seen yet."""
        return cls(jnp.zeros((parameters, parameters), dtype), jnp.zeros(parameters, dtype))

    def read(self, reward: Linear, value: "DependentValue", visited: Trajectories) -> "LeastSquares":
        """Add the values read along `visited` trajectories (d, T)."""
        gradients = reward.scale * jax.vmap(jax.vmap(reward.features))(visited.states, visited.actions)
        values = jax.vmap(jax.vmap(value))(visited.states, visited.actions)
        return self.add(gradients, values, visited.mask.astype(gradients.dtype))

    def add(
        self, gradients: Float[Array, "d T n"], values: Float[Array, "d T"], weights: Float[Array, "d T"]
    ) -> "LeastSquares":
        """Add `values` of r_ld where ∇_θ r^θ is `gradients`, each counted as often as its weight says."""
        return LeastSquares(
            self.gram + jnp.einsum("dt,dtn,dtk->nk", weights, gradients, gradients),
            self.moment + jnp.einsum("dt,dtn,dt->n", weights, gradients, values),
        )

    def solve(self, ridge: float) -> Float[Array, " n"]:
        """argmin Σ (r^θ − r_ld)² + ridge·‖θ‖², projected to the closed unit ball."""
        identity = jnp.eye(self.moment.shape[0], dtype=self.moment.dtype)
        return optax.projections.projection_l2_ball(jnp.linalg.solve(self.gram + ridge * identity, self.moment), 1.0)


class DependentValue(eqx.Module):
    """The oracle for r_ld: its value can be read at any (s, a), and the learner knows nothing else of it."""

    table: AbstractPayoff

    def __call__(self, state: Array, actions: Sides[Array]) -> Float[Array, ""]:
        _, expert_actions = self.table.number_of_actions
        row = jax.tree.map(lambda leaf: leaf[state], self.table)
        one = row.learner_values(jax.nn.one_hot(actions.expert, expert_actions, dtype=jax.tree.leaves(row)[0].dtype))
        return one[actions.learner]
