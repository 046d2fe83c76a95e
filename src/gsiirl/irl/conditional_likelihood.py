"""The conditional likelihood: how probable the expert's choices are, given the states it chose in.

    ℓ(θ) = Σ_j Σ_(t,s,a_e) n_j(t, s, a_e) ln π_e(a_e|s,t; π_l(j), θ)

n_j are counts of what the expert did in interaction j, while the learner played π_l(j). Neither the chance in the
transitions nor the learner's own choices enter. With q = Q_e/τ the response's action values in units of τ, and
J = ∂q/∂θ, its derivatives are

    ∇ℓ = Σ J'(n − n(t,s) π_e),        F = Σ n(t,s) J'(diag(π_e) − π_e π_e')J,

F being the Fisher information: minus the Hessian, in expectation.

Weights θ are in units of the temperature: an expert with reward r_e and temperature τ is the expert with r_e/τ and 1.
"""

from collections.abc import Callable
from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from gsiirl.equilibria.response import respond
from gsiirl.games.base import AbstractTabularGame
from gsiirl.irl.expectations import state_distributions
from gsiirl.irl.memory import Memory
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.types import Sides, Trajectories

Total = TypeVar("Total")
BLOCK = 2**17
"""Numbers that are worked on at once: about what fits a processor's cache."""


class Seen(eqx.Module):
    """What is kept of one interaction: the learner's policy, and how often the expert did what, when and where."""

    learner_policy: Float[Array, "*M T S A_l"]
    counts: Float[Array, "*M T S A_e"]


class ConditionalLikelihood(eqx.Module):
    """ℓ(θ) for an expert that responds softly in `game`, with the reward θ·φ in units of its temperature."""

    game: AbstractTabularGame
    features: AbstractFeatures
    discount: float | Float[Array, ""]

    @property
    def number_of_weights(self) -> int:
        """m."""
        return self.features.number

    def seen(self, learner_policy: Float[Array, "T S A_l"], demonstrations: Trajectories) -> Seen:
        """What is kept of `demonstrations` against `learner_policy`."""
        shape = (self.game.horizon, self.game.number_of_states, self.game.number_of_actions.expert)
        states = demonstrations.states
        steps = jnp.broadcast_to(jnp.arange(states.shape[-1], dtype=states.dtype), states.shape)
        weights = demonstrations.mask.astype(learner_policy.dtype)
        counts = jnp.zeros(shape, learner_policy.dtype).at[steps, states, demonstrations.actions.expert].add(weights)
        return Seen(learner_policy, counts)

    def action_values(self, weights: Float[Array, " m"], learner_policy: Float[Array, "T S A_l"]) -> Array:
        """q (T, S, A_e): Q_e/τ of the response to `learner_policy`; `FORBIDDEN` where an action may not be chosen."""
        return respond(self.game, learner_policy, self.features.payoff(weights), 1.0, self.discount).action_values

    def discrimination(
        self, learner_policy: Float[Array, "T S A_l"], weights: Float[Array, " m"], others: Float[Array, " m"]
    ) -> Float[Array, ""]:
        """How much an episode against `learner_policy` tells `weights`, were they true, from `others`; in nats.

        D = Σ_t Σ_s d_t(s) KL(π_e(·|s, t; weights) ‖ π_e(·|s, t; others)), the expected log-likelihood ratio.
        """
        values = (self.action_values(each, learner_policy) for each in (weights, others))
        return expected_log_ratio(self.game, learner_policy, *values)

    def value(self, weights: Float[Array, " m"], memory: Memory[Seen]) -> Float[Array, ""]:
        """ℓ(θ) over what is remembered."""
        return self.over_memory(memory, lambda each: self.one_value(weights, each), 8)

    def gradient(self, weights: Float[Array, " m"], memory: Memory[Seen]) -> Float[Array, " m"]:
        """∇ℓ(θ)."""
        return self.over_memory(memory, lambda each: jax.grad(self.one_value)(weights, each), 16)

    def value_and_gradient(self, weights: Float[Array, " m"], memory: Memory[Seen]) -> tuple[Array, Array]:
        """ℓ(θ) and ∇ℓ(θ)."""
        return self.over_memory(memory, lambda each: jax.value_and_grad(self.one_value)(weights, each), 16)

    def fisher(
        self, weights: Float[Array, " m"], memory: Memory[Seen], newest: Int[Array, ""] | None = None
    ) -> Float[Array, "m m"]:
        """F at θ of all interactions, or of the `newest` so many; takes memory of m numbers for every (t, s, a_e)."""
        kept, number = memory.kept, memory.held
        if newest is not None:
            number = newest
            counted = (jnp.arange(memory.capacity, dtype=newest.dtype) < newest).astype(kept.counts.dtype)
            kept = Seen(kept.learner_policy, kept.counts * counted[:, None, None, None])
        return self._over(kept, number, lambda each: self._fisher(weights, each), self.number_of_weights)

    @property
    def costly(self) -> bool:
        """Whether F takes so long that an old one is better than none: the Jacobian fills a good part of the cache."""
        entries = self.game.horizon * self.game.number_of_states * self.game.number_of_actions.expert
        return entries * self.number_of_weights > BLOCK // 8

    def fisher_times(self, weights: Float[Array, " m"], vector: Float[Array, " m"], memory: Memory[Seen]) -> Array:
        """F v (m,), without F."""

        def product(each: Seen) -> Array:
            def q(theta: Array) -> Array:
                return self.action_values(theta, each.learner_policy)

            values, moved = jax.jvp(q, (weights,), (vector,))
            policy, visits = jax.nn.softmax(values, axis=-1), jnp.sum(each.counts, axis=-1, keepdims=True)
            spread = visits * policy * (moved - jnp.sum(policy * moved, axis=-1, keepdims=True))
            return jax.vjp(q, weights)[1](spread)[0]

        return self.over_memory(memory, product, 32)

    def fisher_noise(self, weights: Float[Array, " m"], key: Array, memory: Memory[Seen]) -> Float[Array, " m"]:
        """One draw (m,) from N(0, F), without F: Σ J' ξ with ξ ~ N(0, n(diag(π_e) − π_e π_e'))."""
        slots = jnp.arange(memory.capacity)

        def draw(slot_and_seen: tuple[Array, Seen]) -> Array:
            slot, each = slot_and_seen

            def q(theta: Array) -> Array:
                return self.action_values(theta, each.learner_policy)

            values, back = jax.vjp(q, weights)
            policy, visits = jax.nn.softmax(values, axis=-1), jnp.sum(each.counts, axis=-1, keepdims=True)
            noise = jax.random.normal(jax.random.fold_in(key, slot), policy.shape, policy.dtype) * jnp.sqrt(policy)
            return back(jnp.sqrt(visits) * (noise - policy * jnp.sum(noise, -1, keepdims=True)))[0]

        return self._over((slots, memory.kept), memory.held, draw, 32)

    def over_memory(self, memory: Memory[Seen], function: Callable[[Seen], Total], size: int) -> Total:
        """Σ_j function(interaction j), a block of interactions at a time; `size` numbers for every (t, s, a_e)."""
        return self._over(memory.kept, memory.held, function, size)

    def _over(self, kept, number: Array, function, size: int):
        """Σ function over the first `number` of `kept`; those after them in their block must count nothing."""
        capacity = jax.tree.leaves(kept)[0].shape[0]
        entries = self.game.horizon * self.game.number_of_states * self.game.number_of_actions.expert
        block = _divisor(capacity, max(1, BLOCK // (entries * size)))
        blocks = jax.tree.map(lambda leaf: leaf.reshape(-1, block, *leaf.shape[1:]), kept)

        def sum_of(index: Array):
            here = jax.tree.map(lambda leaf: leaf[index], blocks)
            return jax.tree.map(lambda leaf: jnp.sum(leaf, axis=0), jax.vmap(function)(here))

        nothing = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), jax.eval_shape(sum_of, 0))
        return jax.lax.fori_loop(
            0, (number + block - 1) // block, lambda i, total: jax.tree.map(jnp.add, total, sum_of(i)), nothing
        )

    def one_value(self, weights: Float[Array, " m"], seen: Seen) -> Float[Array, ""]:
        """ℓ(θ) of one interaction."""
        return jnp.sum(seen.counts * jax.nn.log_softmax(self.action_values(weights, seen.learner_policy), axis=-1))

    def _fisher(self, weights: Array, seen: Seen) -> Float[Array, "m m"]:
        m = self.number_of_weights
        values, linear = jax.linearize(lambda theta: self.action_values(theta, seen.learner_policy), weights)
        jacobian = jax.vmap(linear)(jnp.eye(m, dtype=weights.dtype))
        policy, visits = jax.nn.softmax(values, axis=-1), jnp.sum(seen.counts, axis=-1)
        mean = jnp.einsum("mtse,tse->mts", jacobian, policy).reshape(m, -1)
        flat = jacobian.reshape(m, -1)
        squares = (flat * (visits[..., None] * policy).reshape(1, -1)) @ flat.T
        return squares - (mean * visits.reshape(1, -1)) @ mean.T


def _divisor(number: int, limit: int) -> int:
    """The largest divisor of `number` that is at most `limit`."""
    return max(each for each in range(1, number + 1) if number % each == 0 and each <= limit)


def expected_log_ratio(
    game: AbstractTabularGame,
    learner_policy: Float[Array, "T S A_l"],
    values: Float[Array, "T S A_e"],
    others: Float[Array, "T S A_e"],
) -> Float[Array, ""]:
    """E^(π_l, π_e)[Σ_t ln π_e,t(a_e|s) − ln π'_e,t(a_e|s)] = Σ_t Σ_s d_t(s) KL(π_e,t(·|s) ‖ π'_e,t(·|s)).

    In nats an episode, and never below 0. π_e ∝ exp(`values`) and π'_e ∝ exp(`others`): action values q in units of the
    temperature, since a probability of 0 has no logarithm.
    """
    log_policies = [jax.nn.log_softmax(each) for each in (values, others)]
    policy = jnp.exp(log_policies[0])
    visits = state_distributions(game, Sides(learner_policy, policy))
    return jnp.sum(visits[..., None] * policy * (log_policies[0] - log_policies[1]))
