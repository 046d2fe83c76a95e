"""The expert's soft best response to a played learner policy.

With the learner's policy given this is a single-agent problem: backward in t, from V_T = 0,

    q_t(s, a_e) = E_{a_l ~ π_l,t}[r_e(s, a) + γ E V_t+1(s')],   π_e,t ∝ exp(q_t / τ),   V_t = τ logsumexp(q_t / τ).

over the actions that the expert may choose; V is 0 in terminal states. At a logit equilibrium it returns exactly the
equilibrium's π_e.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.games.base import AbstractTabularGame, only_allowed
from gsiirl.games.payoff import AbstractPayoff


class Response(eqx.Module):
    """The response π_e (T, S, A_e), its soft values V_e (T, S) in reward units, and q/τ (T, S, A_e)."""

    policy: Float[Array, "*T S A_e"]
    values: Float[Array, "*T S"]
    action_values: Float[Array, "*T S A_e"]


def respond(
    game: AbstractTabularGame,
    learner_policy: Float[Array, "T S A_l"],
    expert_reward: AbstractPayoff,
    temperature: float | Float[Array, ""],
    discount: float | Float[Array, ""],
) -> Response:
    """The expert's soft best response to `learner_policy` under `expert_reward`, at temperature τ in reward units."""

    def backward(values, learner_policy_now):
        answer = respond_now(game, learner_policy_now, expert_reward, temperature, discount, values)
        return answer.values, answer

    _, response = jax.lax.scan(backward, jnp.zeros_like(game.initial), learner_policy, reverse=True)
    return response


def respond_now(
    game: AbstractTabularGame,
    learner_policy: Float[Array, "S A_l"],
    expert_reward: AbstractPayoff,
    temperature: float | Float[Array, ""],
    discount: float | Float[Array, ""],
    values: Float[Array, " S"],
) -> Response:
    """One step t of the recursion: π_e,t, V_t and q_t/τ, from V_t+1 (`values`)."""
    payoff = expert_reward + game.continuation(values) * discount
    action_values = only_allowed(payoff.expert_values(learner_policy) / temperature, game.allowed.expert)
    values = game.alive(temperature * jax.nn.logsumexp(action_values, axis=-1))
    return Response(jax.nn.softmax(action_values, axis=-1), values, action_values)
