"""The gradient of the lower level, with the learner's policy as it was played (docs/deviations.md).

    L(θ_e) = −E_D[Σ_t γ^t ln π_e^θ_e(a_e,t|s_t)] + (λ/2)‖θ_e‖²,     π_e^θ_e = respond(π_l played, r_e^θ_e)

Lemma 1:  ∇L = (μ_e(π_l, π_e^θ_e) − μ̂_e(D))/τ + λ θ_e.  It is exact for exact occupancies, and holds in expectation
for samples.
"""

from jaxtyping import Array, Float

from gsiirl.equilibria.response import respond
from gsiirl.games.base import AbstractTabularGame
from gsiirl.irl.expectations import reward_gradient_expectation
from gsiirl.rewards.linear import Linear
from gsiirl.types import Sides


def played_gradient(
    game: AbstractTabularGame,
    reward: Linear,
    parameters: Float[Array, " m"],
    learner_policy: Float[Array, "T S A_l"],
    demonstrated: Float[Array, " m"],
    temperature: float | Float[Array, ""],
    discount: float | Float[Array, ""],
) -> Float[Array, " m"]:
    """∇L without λθ_e for one interaction, (μ_e(π_l, respond(π_l, θ_e)) − μ̂_e)/τ; `demonstrated` is μ̂_e(D)."""
    response = respond(game, learner_policy, reward.payoff(parameters), temperature, discount)
    modelled = reward_gradient_expectation(game, reward, Sides(learner_policy, response.policy), discount)
    return (modelled - demonstrated) / temperature
