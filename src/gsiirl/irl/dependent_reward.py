"""The learner's expert-dependent reward, fitted to the values it reads where it has been."""

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float

from gsiirl.games.payoff import AbstractPayoff
from gsiirl.rewards.linear import AbstractFeatures, IndicatorFeatures, Linear
from gsiirl.types import Number, Sides, Trajectories


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

    def solve(self, ridge: Number) -> Float[Array, " n"]:
        """argmin Σ (r^θ − r_ld)² + ridge·‖θ‖², projected to the closed unit ball."""
        identity = jnp.eye(self.moment.shape[0], dtype=self.moment.dtype)
        return optax.projections.projection_l2_ball(jnp.linalg.solve(self.gram + ridge * identity, self.moment), 1.0)


class DependentFit(eqx.Module):
    """r_ld fitted by least squares, without a bound: for rewards that are read without noise.

    `gram` Σ φφ' is (n, n), or its diagonal (n,) for one weight a state and joint action; `moment` is Σ φ r_ld.
    """

    gram: Float[Array, "..."]
    moment: Float[Array, " n"]

    @classmethod
    def empty(cls, features: AbstractFeatures, dtype: jnp.dtype) -> "DependentFit":
        """Nothing seen yet."""
        n = features.number
        shape = (n,) if isinstance(features, IndicatorFeatures) else (n, n)
        return cls(jnp.zeros(shape, dtype), jnp.zeros(n, dtype))

    def read(self, features: AbstractFeatures, value: "DependentValue", visited: Trajectories) -> "DependentFit":
        """Add the values read along `visited` trajectories (d, T)."""
        values = jax.vmap(jax.vmap(value))(visited.states, visited.actions)
        weights = visited.mask.astype(values.dtype)
        if isinstance(features, IndicatorFeatures):
            place = features.place(visited.states, visited.actions)
            gram, moment = self.gram.at[place].add(weights), self.moment.at[place].add(weights * values)
            return DependentFit(gram, moment)
        gradients = jax.vmap(jax.vmap(features))(visited.states, visited.actions)
        return DependentFit(
            self.gram + jnp.einsum("dt,dtn,dtk->nk", weights, gradients, gradients),
            self.moment + jnp.einsum("dt,dtn,dt->n", weights, gradients, values),
        )

    def solve(self) -> Float[Array, " n"]:
        """The weights that fit best; of several equally good ones, the smallest. 0 where nothing was read."""
        if self.gram.ndim == 1:
            return jnp.where(self.gram > 0, self.moment / jnp.maximum(self.gram, 1.0), 0.0)
        # A ridge far below what was read: it decides only what the data leave open.
        scale = jnp.maximum(jnp.trace(self.gram) / self.moment.shape[0], 1e-300)
        identity = jnp.eye(self.moment.shape[0], dtype=self.moment.dtype)
        return jnp.linalg.solve(self.gram + 1e-10 * scale * identity, self.moment)


class DependentValue(eqx.Module):
    """The oracle for r_ld: its value can be read at any (s, a), and the learner knows nothing else of it."""

    table: AbstractPayoff

    def __call__(self, state: Array, actions: Sides[Array]) -> Float[Array, ""]:
        _, expert_actions = self.table.number_of_actions
        row = jax.tree.map(lambda leaf: leaf[state], self.table)
        one = row.learner_values(jax.nn.one_hot(actions.expert, expert_actions, dtype=jax.tree.leaves(row)[0].dtype))
        return one[actions.learner]
