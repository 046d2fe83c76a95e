"""Physical deception: MPE's `simple_adversary`, as mpe2 1.1.1 steps it (paper 8.1, A.10.1).

Two good agents (together the learner) know which of two landmarks is the target, the adversary (the expert) does not.
All are points of mass 1 under forces u = 5 · action, |action| ≤ 1 along each axis, with damping 1/4:

    p' = p + 0.1 v,     v' = 0.75 v + 0.1 u

The position is moved by the velocity before the force, so that an action shows in the positions two steps later.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from gsiirl.games.base import AbstractContinuousGame
from gsiirl.types import Sides

TIME_STEP = 0.1
DAMPING = 0.25
FORCE = 5.0


class DeceptionState(eqx.Module):
    """Positions and velocities of adversary, agent 0 and agent 1, in this order; the landmarks, and each side's target.

    `targets` are indices of landmarks.
    """

    positions: Float[Array, "3 2"]
    velocities: Float[Array, "3 2"]
    landmarks: Float[Array, "2 2"]
    targets: Sides[Int[Array, ""]]

    @property
    def target_places(self) -> Sides[Float[Array, " 2"]]:
        """Where each side's target is."""
        return jax.tree.map(lambda index: self.landmarks[index], self.targets)


class Deception(AbstractContinuousGame[DeceptionState]):
    """Dynamics of physical deception.

    The learner's action is (x, y) of agent 0, then of agent 1. Each good agent observes, relative to itself, its
    target, both landmarks, the adversary and the other agent; the learner sees the observations of both. The adversary
    observes, relative to itself, both landmarks and both agents, and no target. Nobody observes velocities.

    With `separate_target` the adversary's target is the landmark that is not the good agents'; else they share one.
    """

    horizon: int = eqx.field(static=True, default=25)
    separate_target: bool = eqx.field(static=True, default=False)

    @property
    def action_size(self) -> Sides[int]:
        return Sides(4, 2)

    def reset(self, key: PRNGKeyArray) -> DeceptionState:
        place_key, landmark_key, target_key = jax.random.split(key, 3)
        target = jax.random.bernoulli(target_key).astype(jnp.int32)
        return DeceptionState(
            positions=jax.random.uniform(place_key, (3, 2), jnp.float32, -1.0, 1.0),
            velocities=jnp.zeros((3, 2), jnp.float32),
            landmarks=jax.random.uniform(landmark_key, (2, 2), jnp.float32, -1.0, 1.0),
            targets=Sides(target, 1 - target if self.separate_target else target),
        )

    def step(self, state: DeceptionState, actions: Sides[Float[Array, "..."]]) -> DeceptionState:
        force = FORCE * jnp.concatenate([actions.expert, actions.learner]).reshape(3, 2)
        return DeceptionState(
            positions=state.positions + TIME_STEP * state.velocities,
            velocities=(1.0 - DAMPING) * state.velocities + TIME_STEP * force,
            landmarks=state.landmarks,
            targets=state.targets,
        )

    def observe(self, state: DeceptionState) -> Sides[Float[Array, "..."]]:
        target = state.target_places.learner
        adversary, first, second = state.positions

        def relative(own: Array, *others: Array) -> Array:
            return (jnp.stack(others) - own[None]).ravel()

        landmarks = tuple(state.landmarks)
        return Sides(
            jnp.concatenate(
                [
                    relative(first, target, *landmarks, adversary, second),
                    relative(second, target, *landmarks, adversary, first),
                ]
            ),
            relative(adversary, *landmarks, first, second),
        )
