"""How alike two linear rewards are, over all state-actions of a tabular game.

Both measures are ratios of quadratic forms in the weights, so the features' second moments are taken once and every
comparison after that costs O(m²). States and joint actions are uniform.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.games.base import AbstractTabularGame
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.types import Sides

_LARGEST_SAMPLE = 2_000_000


class RewardSimilarity(eqx.Module):
    """Second moments of features φ(s, a): around their means over actions, and of those means over states.

    With A uniform over joint actions, `within` = E_s Cov_A(φ(s, A)) and `between` = Cov_s(E_A φ(s, A)), both (m, m).
    """

    within: Float[Array, "m m"]
    between: Float[Array, "m m"]

    @classmethod
    def of(cls, game: AbstractTabularGame, features: AbstractFeatures) -> "RewardSimilarity":
        """Over the game's states, or an even spread of as many of them as make two million state-actions."""
        actions = game.number_of_actions
        joint = actions.learner * actions.expert
        states = max(1, min(game.number_of_states, _LARGEST_SAMPLE // joint))
        spread = np.unique(np.linspace(0, game.number_of_states - 1, states).round().astype(int))
        learner, expert = (jnp.asarray(axis.ravel()) for axis in np.indices((actions.learner, actions.expert)))

        def of_state(state: Array) -> tuple[Array, Array]:
            table = jax.vmap(lambda a_l, a_e: features(state, Sides(a_l, a_e)))(learner, expert)
            mean = jnp.mean(table, axis=0)
            return table.T @ table / joint - jnp.outer(mean, mean), mean

        covariances, means = jax.lax.map(of_state, jnp.asarray(spread))
        centred = means - jnp.mean(means, axis=0)[None, :]
        return cls(jnp.mean(covariances, axis=0), centred.T @ centred / means.shape[0])

    def pearson(self, first: Float[Array, " m"], second: Float[Array, " m"]) -> Float[Array, ""]:
        """Pearson correlation of two rewards over uniform (s, a)."""
        return _cosine(self.within + self.between, first, second)

    def epic(self, first: Float[Array, " m"], second: Float[Array, " m"], discount: float) -> Float[Array, ""]:
        """EPIC distance √((1 − ρ)/2) ∈ [0, 1] of two rewards r(s, a) (Gleave et al. 2021).

        Canonicalised with A uniform and s, S' independent and uniform: r(s, a) − E_A r(s, A) + γ (E_A r(s', A) − E r).
        """
        correlation = _cosine(self.within + discount**2 * self.between, first, second)
        return jnp.sqrt(jnp.maximum(1.0 - correlation, 0.0) / 2.0)


def _cosine(moments: Float[Array, "m m"], first: Float[Array, " m"], second: Float[Array, " m"]) -> Float[Array, ""]:
    product = jnp.vdot(first, moments @ second)
    variances = jnp.stack([jnp.vdot(weights, moments @ weights) for weights in (first, second)])
    # A reward that is constant but for rounding agrees with nothing: correlation 0, not 0/0.
    rounding = 1e-12 * jnp.trace(moments) * jnp.stack([jnp.vdot(first, first), jnp.vdot(second, second)])
    norms = jnp.sqrt(jnp.prod(variances))
    varies = jnp.all(variances > rounding)
    return jnp.where(varies, product / jnp.where(varies, norms, 1.0), 0.0)
