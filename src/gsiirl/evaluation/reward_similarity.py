"""How alike two linear rewards are, over all state-actions of a tabular game.

Every measure compares c(r) and c(r'), where a linear map c removes what does not matter to it. States and joint actions
are uniform. What is removed:

| measure | c(r) | invariant under |
|---|---|---|
| Pearson | r − E r | scale, a constant |
| EPIC (Gleave et al. 2021) | r − E_A r(s, A) + γ (E_A r(s', A) − E r), s' independent of s | scale, a constant |
| STARC (Skalse et al. 2024) | r − V(s) + γ E[V(s') given s, a], V of uniform play | scale, potential shaping |

A factor (k, m) of each map is computed once, so that ‖factor θ‖² is the mean of c(r)² over state-actions; every
comparison after that costs O(m²).
"""

from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from gsiirl.compilation import QUICKLY
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.types import Sides

_LARGEST_SAMPLE = 2_000_000
MOST_DISCOUNT = 0.99
"""Above it values of play that never ends are of no use, and STARC takes this discount instead."""


class RewardSimilarity(eqx.Module):
    """The factors of the three maps, for the features φ(s, a) of a game."""

    of_pearson: Float[Array, "k m"]
    of_epic: Float[Array, "k m"]
    of_starc: Float[Array, "m m"]

    @classmethod
    def of(cls, game: AbstractTabularGame, features: AbstractFeatures, discount: float) -> "RewardSimilarity":
        """Over the game's states, or an even spread of as many of them as make two million state-actions."""
        actions = game.number_of_actions
        states = max(1, min(game.number_of_states, _LARGEST_SAMPLE // (actions.learner * actions.expert)))
        spread = np.unique(np.linspace(0, game.number_of_states - 1, states).round().astype(int))
        return _factors(game, features, jnp.asarray(discount, game.initial.dtype), jnp.asarray(spread))

    def pearson(self, first: Float[Array, " m"], second: Float[Array, " m"]) -> Float[Array, ""]:
        """Pearson correlation of two rewards over uniform (s, a)."""
        one, other = _normed(self.of_pearson, first), _normed(self.of_pearson, second)
        return jnp.vdot(one, other)

    def epic(self, first: Float[Array, " m"], second: Float[Array, " m"]) -> Float[Array, ""]:
        """EPIC distance ½‖c(r)/‖c(r)‖ − c(r')/‖c(r')‖‖ ∈ [0, 1] of two rewards r(s, a); 0 the same, 1 the opposite."""
        return _distance(self.of_epic, first, second)

    def starc(self, first: Float[Array, " m"], second: Float[Array, " m"]) -> Float[Array, ""]:
        """STARC distance, likewise; 0 the same but for scale and shaping, which no policy for ever depends on."""
        return _distance(self.of_starc, first, second)

    def without(self, directions: Float[Array, "m k"]) -> "RewardSimilarity":
        """The same measures of what is left of c(r) and c(r') beside the images of these `directions` of weights.

        They then compare classes of rewards that differ by such directions, and 0 is reached within a class.
        """

        def projected(factor: Array) -> Array:
            left, sizes, _ = jnp.linalg.svd(factor @ directions, full_matrices=False)
            kept = jnp.where(sizes[None, :] > 1e-10 * jnp.linalg.norm(factor), left, 0.0)
            return factor - kept @ (kept.T @ factor)

        return RewardSimilarity(projected(self.of_pearson), projected(self.of_epic), projected(self.of_starc))


@partial(jax.jit, compiler_options=QUICKLY)
def _factors(
    game: AbstractTabularGame, features: AbstractFeatures, discount: Array, spread: Int[Array, " k"]
) -> RewardSimilarity:
    """The three factors, by one program: op by op, compiling would take longer than all else."""
    actions, m = game.number_of_actions, features.number
    joint = actions.learner * actions.expert
    learner, expert = (jnp.asarray(axis.ravel()) for axis in np.indices((actions.learner, actions.expert)))
    lasting = jnp.minimum(discount, MOST_DISCOUNT)
    values, ahead = _values_of_uniform_play(game, features, lasting)

    def of_state(factors: tuple[Array, Array], state: Array) -> tuple[tuple[Array, Array], Array]:
        table = jax.vmap(lambda a_l, a_e: features(state, Sides(a_l, a_e)))(learner, expert)
        mean = jnp.mean(table, axis=0)
        following = jax.tree.map(lambda leaf: leaf[:, state], ahead).dense().reshape(m, joint).T
        rows = table - mean[None, :], table - values[:, state][None, :] + lasting * following
        return (_stacked(factors[0], rows[0]), _stacked(factors[1], rows[1])), mean

    nothing = jnp.zeros((m, m), values.dtype)
    (within, shaped), means = jax.lax.scan(of_state, (nothing, nothing), spread)
    between = _stacked(nothing, means - jnp.mean(means, axis=0)[None, :]) * joint**0.5
    number = (len(spread) * joint) ** 0.5
    return RewardSimilarity(
        jnp.concatenate([within, between]) / number,
        jnp.concatenate([within, discount * between]) / number,
        shaped / number,
    )


def _values_of_uniform_play(
    game: AbstractTabularGame, features: AbstractFeatures, discount: Array
) -> tuple[Float[Array, "m S"], AbstractPayoff]:
    """V (m, S) of each feature where both sides play uniformly for ever, and E[V(s') given s, a] as payoffs (m, S)."""
    actions, dtype = game.number_of_actions, game.initial.dtype
    learner, expert = (
        jnp.full((game.number_of_states, number), 1.0 / number, dtype) for number in (actions.learner, actions.expert)
    )
    each = jnp.eye(features.number, dtype=dtype)
    earned = jax.vmap(lambda weights: features.payoff(weights).expected(learner, expert))(each)

    def backward(values: Array) -> Array:
        onward = jax.vmap(lambda one: game.continuation(one).expected(learner, expert))(values)
        return game.alive(earned + discount * onward)

    def body(carry: tuple[Array, Array]) -> tuple[Array, Array]:
        after = backward(carry[0])
        return after, jnp.max(jnp.abs(after - carry[0]))

    size = jnp.max(jnp.abs(earned))
    values, _ = jax.lax.while_loop(lambda carry: carry[1] > 1e-14 * size, body, (game.alive(earned), size))
    return values, jax.vmap(game.continuation)(values)


def _stacked(factor: Float[Array, "m m"], rows: Float[Array, "n m"]) -> Float[Array, "m m"]:
    """R (m, m) with R'R = factor'factor + rows'rows."""
    return jnp.linalg.qr(jnp.concatenate([factor, rows]), mode="r")


def _normed(factor: Float[Array, "k m"], weights: Float[Array, " m"]) -> Float[Array, " k"]:
    """c(r)/‖c(r)‖, or 0 where c(r) is 0 but for rounding: such a reward is like nothing."""
    mapped = factor @ weights
    size = jnp.linalg.norm(mapped)
    varies = size > 1e-6 * jnp.linalg.norm(factor) * jnp.linalg.norm(weights)
    return jnp.where(varies, mapped / jnp.where(varies, size, 1.0), 0.0)


def _distance(factor: Float[Array, "k m"], first: Float[Array, " m"], second: Float[Array, " m"]) -> Float[Array, ""]:
    one, other = _normed(factor, first), _normed(factor, second)
    # As far as from an unrelated reward, where one of them is like nothing.
    nothing = (jnp.vdot(one, one) == 0) | (jnp.vdot(other, other) == 0)
    return jnp.where(nothing, 0.5**0.5, 0.5 * jnp.linalg.norm(one - other))
