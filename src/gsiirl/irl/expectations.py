"""Expectations under a joint policy: state distributions, returns, and reward gradient expectations."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.rewards.linear import Linear
from gsiirl.types import Policies, Trajectories


def state_distributions(game: AbstractTabularGame, policies: Policies) -> Float[Array, "T S"]:
    """d_t(s) = P(s_t = s | π), t = 0, …, T − 1; 0 in terminal states, where nothing happens any more."""

    def forward(distribution, policies_now):
        return game.advance(distribution, policies_now), game.alive(distribution)

    _, distributions = jax.lax.scan(forward, game.initial, policies)
    return distributions


def expected_return(
    game: AbstractTabularGame, reward: AbstractPayoff, policies: Policies, discount: float | Float[Array, ""]
) -> Float[Array, ""]:
    """E^π[Σ_t γ^t r(s_t, a_t)] by backward recursion; `discount` = 1 gives the undiscounted return."""

    def backward(values, policies_now):
        payoff = reward + game.continuation(values) * discount
        return game.alive(payoff.expected(policies_now.learner, policies_now.expert)), None

    values, _ = jax.lax.scan(backward, jnp.zeros_like(game.initial), policies, reverse=True)
    return jnp.vdot(game.initial, values)


def reward_gradient_expectation(
    game: AbstractTabularGame, reward: Linear, policies: Policies, discount: float | Float[Array, ""]
) -> Float[Array, " m"]:
    """μ(π) = E^π[Σ_t γ^t ∇_θ r^θ(s_t, a_t)] ∈ R^m, exactly (the paper's Lemma 1)."""
    distributions = state_distributions(game, policies)
    weights = discount ** jnp.arange(game.horizon, dtype=distributions.dtype)

    def total(parameters: Float[Array, " m"]) -> Float[Array, ""]:
        payoff = reward.payoff(parameters)
        expected = jax.vmap(lambda now: payoff.expected(now.learner, now.expert))(policies)
        return jnp.sum(weights[:, None] * distributions * expected)

    # A linear reward makes the total linear in the parameters, so its gradient anywhere is μ.
    return jax.grad(total)(jnp.zeros(reward.number_of_parameters, distributions.dtype))


def sampled_reward_gradient(
    reward: Linear, demonstrations: Trajectories, discount: float | Float[Array, ""], dtype: jnp.dtype
) -> Float[Array, " m"]:
    """μ̂(D) = (1/d) Σ_{i=1..d} Σ_t γ^t ∇_θ r^θ(s_it, a_it) ∈ R^m, over the d trajectories of D."""
    features = jax.vmap(jax.vmap(reward.features))(demonstrations.states, demonstrations.actions)
    steps = jnp.arange(features.shape[1], dtype=dtype)
    weights = (discount**steps)[None, :] * demonstrations.mask.astype(dtype)
    return reward.scale * jnp.einsum("dt,dtm->m", weights, features) / features.shape[0]
