"""Rewards of physical deception: the learner's own, the true ones, and the features that every algorithm shares.

mpe2 pays a step by where everybody is after it:

    r_li = −min_i ‖target − p_i‖,     r_ld = ‖target − p_adversary‖,     r_e = −‖target_e − p_adversary‖

The features of the adversary's reward are minus its distances to everything it could be after: the good agents' target,
the other landmark, either good agent, the centre. Nothing in them says which it is. Those of the learner's dependent
reward are the same distances.
"""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.games.deception import DeceptionState
from gsiirl.rewards.continuous import AbstractTransitionFeatures, length
from gsiirl.types import Transition


class AdversaryDistances(AbstractTransitionFeatures):
    """sign · the adversary's distances after the step."""

    sign: float = eqx.field(static=True)
    names: tuple[str, ...] = eqx.field(
        static=True,
        default=("the agents' target", "the other landmark", "the nearer agent", "the farther agent", "the centre"),
    )

    def __call__(self, transition: Transition) -> Float[Array, " m"]:
        state: DeceptionState = transition.following
        adversary, first, second = state.positions
        target = state.landmarks[state.targets.learner]
        other = state.landmarks[1 - state.targets.learner]
        to_first, to_second = length(first - adversary), length(second - adversary)
        distances = (
            length(target - adversary),
            length(other - adversary),
            jnp.minimum(to_first, to_second),
            jnp.maximum(to_first, to_second),
            length(adversary),
        )
        return self.sign * jnp.stack(distances)


def own_reward(transition: Transition) -> Float[Array, ""]:
    """r_li: minus the distance of the nearer good agent to the target."""
    state: DeceptionState = transition.following
    target = state.target_places.learner
    return -jnp.minimum(length(target - state.positions[1]), length(target - state.positions[2]))


def dependent_reward(transition: Transition) -> Float[Array, ""]:
    """r_ld: the adversary's distance to the good agents' target; what the learner can read, not its formula."""
    state: DeceptionState = transition.following
    return length(state.target_places.learner - state.positions[0])


def adversary_reward(transition: Transition) -> Float[Array, ""]:
    """r_e: minus the adversary's distance to its own target."""
    state: DeceptionState = transition.following
    return -length(state.target_places.expert - state.positions[0])
