"""How far a joint policy is from equilibrium: the yardstick, never the method."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.games.base import AbstractTabularGame, only_allowed
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Policies, Sides


def nash_gap(
    game: AbstractTabularGame, rewards: Sides[AbstractPayoff], policies: Policies, discount: float
) -> Float[Array, ""]:
    """NashConv: Σ_i (max_{π_i'} J_i(π_i', π_-i) − J_i(π)), discounted, from P0; zero at a Nash equilibrium."""
    zero = jnp.zeros((), game.initial.dtype)
    return _gap(game, rewards, policies, discount, zero, lambda values: jnp.max(values, axis=-1))


def regularised_nash_gap(
    game: AbstractTabularGame,
    rewards: Sides[AbstractPayoff],
    policies: Policies,
    discount: float,
    temperature: float | Float[Array, ""],
) -> Float[Array, ""]:
    """NashConv of the entropy-regularised game; zero at a logit equilibrium.

    There J_i(π) = E^π[Σ_t γ^t (r_i(s_t, a_t) + τ H(π_i(·|s_t)))], each side with its own entropy only.
    """
    temperature = jnp.asarray(temperature, game.initial.dtype)

    def soft_maximum(values: Array) -> Array:
        return temperature * jax.nn.logsumexp(values / temperature, axis=-1)

    return _gap(game, rewards, policies, discount, temperature, soft_maximum)


def _gap(game, rewards, policies, discount, temperature, maximum):
    def backward(carry, policies_now):
        best, played = carry
        best_payoffs = Sides(
            rewards.learner + game.continuation(best.learner) * discount,
            rewards.expert + game.continuation(best.expert) * discount,
        )
        best_values = Sides(
            only_allowed(best_payoffs.learner.learner_values(policies_now.expert), game.allowed.learner),
            only_allowed(best_payoffs.expert.expert_values(policies_now.learner), game.allowed.expert),
        )
        best = jax.tree.map(lambda values: game.alive(maximum(values)), best_values)
        learner_payoff = rewards.learner + game.continuation(played.learner) * discount
        expert_payoff = rewards.expert + game.continuation(played.expert) * discount
        played = Sides(
            learner_payoff.expected(policies_now.learner, policies_now.expert)
            + temperature * _entropy(policies_now.learner),
            expert_payoff.expected(policies_now.learner, policies_now.expert)
            + temperature * _entropy(policies_now.expert),
        )
        return (best, jax.tree.map(game.alive, played)), None

    nothing = jnp.zeros_like(game.initial)
    zeros = Sides(nothing, nothing)
    (best, played), _ = jax.lax.scan(backward, (zeros, zeros), policies, reverse=True)
    return jnp.vdot(game.initial, best.learner - played.learner) + jnp.vdot(game.initial, best.expert - played.expert)


def _entropy(policy: Float[Array, "S A"]) -> Float[Array, " S"]:
    return -jnp.sum(jax.scipy.special.xlogy(policy, policy), axis=-1)
