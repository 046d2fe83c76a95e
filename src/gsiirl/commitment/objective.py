"""What a learner earns by committing to a policy that the expert answers.

    f(π_l; θ) = E^(π_l, π_e)[Σ_t γ^t (r_ld + r_li)],    π_e = respond(π_l, θ·φ) at temperature 1

One recursion backward in t gives π_e and f; the gradient by π_l goes through both.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.equilibria.response import respond, respond_now
from gsiirl.games.base import AbstractTabularGame, learner_policy, uniform_policy
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides


class Commitment(eqx.Module):
    """f for one game and the learner's own reward r_ld + r_li; the expert's reward is in units of its temperature."""

    game: AbstractTabularGame
    learner_reward: AbstractPayoff
    discount: float | Float[Array, ""]

    def policy(self, logits: Float[Array, "T S A_l"]) -> Float[Array, "T S A_l"]:
        """π_l ∝ exp(logits) over the actions that the learner may choose."""
        return learner_policy(self.game, logits)

    def value(
        self,
        policy: Float[Array, "T S A_l"],
        expert_reward: AbstractPayoff,
        temperature: float | Float[Array, ""] = 1.0,
        reaction: float | Float[Array, ""] = 1.0,
        discount: float | Float[Array, ""] | None = None,
    ) -> Float[Array, ""]:
        """f(π_l) against the response to it at `temperature`.

        The derivative through the expert's answer counts `reaction` times: 1 for that of f, 0 for a learner that takes
        the answer as given. `discount` is that of the return, the expert's own being the game's.
        """
        earned = self.discount if discount is None else discount

        def backward(values: Sides, policy_now: Array):
            answered = respond_now(self.game, policy_now, expert_reward, temperature, self.discount, values.expert)
            held = jax.lax.stop_gradient(answered.policy)
            answer = held + reaction * (answered.policy - held)
            payoff = self.learner_reward + self.game.continuation(values.learner) * earned
            return Sides(self.game.alive(payoff.expected(policy_now, answer)), answered.values), None

        nothing = jnp.zeros_like(self.game.initial)
        values, _ = jax.lax.scan(backward, Sides(nothing, nothing), policy, reverse=True)
        return jnp.vdot(self.game.initial, values.learner)

    def range_of_answers(self, expert_reward: AbstractPayoff) -> Float[Array, ""]:
        """The largest difference between two of the expert's action values, against a learner that plays uniformly."""
        values = respond(self.game, uniform_policy(self.game), expert_reward, 1.0, self.discount).action_values
        allowed = self.game.allowed.expert
        largest = jnp.max(values, axis=-1)
        smallest = jnp.min(values if allowed is None else jnp.where(allowed[None], values, jnp.inf), axis=-1)
        return jnp.max(largest - smallest)
