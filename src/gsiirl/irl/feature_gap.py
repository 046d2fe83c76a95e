"""How the expert's modelled episodes differ from the ones that were seen, in features of its reward."""

import jax
from jaxtyping import Array, Float, PyTree

from gsiirl.rewards.continuous import AbstractTransitionReward, mean_return
from gsiirl.types import Transition


def first_states(episodes: Transition) -> PyTree:
    """The initial states of episodes (axes d, T)."""
    return jax.tree.map(lambda leaf: leaf[:, 0], episodes.state)


def reward_gap(
    reward: AbstractTransitionReward,
    parameters: Float[Array, " m"],
    modelled: Transition,
    demonstrated: Transition,
    discount: float,
) -> Float[Array, " m"]:
    """(μ(modelled) − μ(demonstrated)) / scale with μ = (1/d) Σ_i Σ_t γ^t ∇_θ r^θ, in features for a linear reward."""

    def difference(theta: Array) -> Array:
        modelled_return, demonstrated_return = (
            mean_return(lambda seen: reward(theta, seen), episodes, discount) for episodes in (modelled, demonstrated)
        )
        return modelled_return - demonstrated_return

    return jax.grad(difference)(parameters) / reward.scale


def gaps_of_episodes(
    reward: AbstractTransitionReward,
    parameters: Float[Array, " m"],
    modelled: Transition,
    demonstrated: Transition,
    discount: float,
) -> Float[Array, "d m"]:
    """`reward_gap` of every pair of episodes alone; their mean is that of all."""

    def alone(one: Transition, other: Transition) -> Array:
        one, other = jax.tree.map(lambda leaf: leaf[None], (one, other))
        return reward_gap(reward, parameters, one, other, discount)

    return jax.vmap(alone)(modelled, demonstrated)
