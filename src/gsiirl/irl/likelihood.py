"""The lower level's objective and its gradient, with the learner's policy as it was played (docs/deviations.md).

    L(θ_e) = −E_D[Σ_t γ^t ln π_e^θ_e(a_e,t|s_t)] + (λ/2)‖θ_e‖²,     π_e^θ_e = respond(π_l played, r_e^θ_e)

Lemma 1:  ∇L = (μ_e(π_l, π_e^θ_e) − μ̂_e(D))/τ + λ θ_e.  It is exact for exact occupancies, and holds in expectation
for samples.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.equilibria.response import respond
from gsiirl.games.base import AbstractTabularGame
from gsiirl.irl.expectations import reward_gradient_expectation, state_distributions
from gsiirl.rewards.linear import Linear
from gsiirl.types import Policies, Sides


def expected_negative_log_likelihood(
    game: AbstractTabularGame,
    reward: Linear,
    parameters: Float[Array, " m"],
    demonstrated: Policies,
    temperature: float | Float[Array, ""],
    discount: float | Float[Array, ""],
    regularisation: float,
) -> Float[Array, ""]:
    """L of infinitely many demonstrations: the expectation over exact occupancies of the `demonstrated` policies."""
    response = respond(game, demonstrated.learner, reward.payoff(parameters), temperature, discount)
    distributions = state_distributions(game, demonstrated)
    weights = discount ** jnp.arange(game.horizon, dtype=distributions.dtype)
    log_likelihood = jnp.sum(demonstrated.expert * jnp.log(response.policy), axis=-1)
    penalty = 0.5 * regularisation * jnp.sum(parameters**2)
    return penalty - jnp.sum(weights[:, None] * distributions * log_likelihood)


def played_gradient(
    game: AbstractTabularGame,
    reward: Linear,
    parameters: Float[Array, " m"],
    learner_policy: Float[Array, "T S A_l"],
    demonstrated: Float[Array, " m"],
    temperature: float | Float[Array, ""],
    discount: float | Float[Array, ""],
    regularisation: float,
) -> Float[Array, " m"]:
    """Lemma 1 for one interaction: (μ_e(π_l, respond(π_l, θ_e)) − μ̂_e)/τ + λ θ_e, `demonstrated` being μ̂_e(D)."""
    response = respond(game, learner_policy, reward.payoff(parameters), temperature, discount)
    modelled = reward_gradient_expectation(game, reward, Sides(learner_policy, response.policy), discount)
    return (modelled - demonstrated) / temperature + regularisation * parameters
