"""A robot and a person cross each other's way, two points in the plane (paper 8.2, A.10.2).

    p' = p + v,     v = 0.1 · action,     |v_x|, |v_y| ≤ 0.1

The robot (learner) starts in [−0.25, 0.25] × [−0.5, −0.4] and heads for (0, 0.5); the human (expert) starts in
[0.4, 0.5] × [−0.25, 0.25]. Where the human heads for is no part of the game: it is in the human's reward alone.
Other starts and other speeds make another game with the same rewards.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.games.base import AbstractContinuousGame
from gsiirl.types import Number, Sides

Box = tuple[tuple[Number, Number], tuple[Number, Number]]
"""Where a side may start: least and largest x, least and largest y."""
LARGEST_STEP = 0.1
"""Largest displacement along an axis in one step."""
ROBOT_START = ((-0.25, 0.25), (-0.5, -0.4))
HUMAN_START = ((0.4, 0.5), (-0.25, 0.25))


class CrossingState(eqx.Module):
    """Where both are, (x, y) each."""

    positions: Sides[Float[Array, " 2"]]


class Crossing(AbstractContinuousGame[CrossingState]):
    """Dynamics of the crossing: each side picks its velocity. Both see both positions."""

    horizon: int = eqx.field(static=True, default=30)
    starts: Sides[Box] = Sides(ROBOT_START, HUMAN_START)
    largest_step: Sides[Number] = Sides(LARGEST_STEP, LARGEST_STEP)

    @property
    def action_size(self) -> Sides[int]:
        return Sides(2, 2)

    def reset(self, key: PRNGKeyArray) -> CrossingState:
        learner_key, expert_key = jax.random.split(key)
        return CrossingState(Sides(_within(learner_key, self.starts.learner), _within(expert_key, self.starts.expert)))

    def step(self, state: CrossingState, actions: Sides[Float[Array, " 2"]]) -> CrossingState:
        def moved(place: Array, action: Array, largest: Number) -> Array:
            return place + largest * action

        return CrossingState(jax.tree.map(moved, state.positions, actions, self.largest_step))

    def observe(self, state: CrossingState) -> Sides[Float[Array, " 4"]]:
        robot, human = state.positions.learner, state.positions.expert
        return Sides(jnp.concatenate([robot, human]), jnp.concatenate([human, robot]))


def _within(key: PRNGKeyArray, box: Box) -> Float[Array, " 2"]:
    (left, right), (low, high) = box
    return jax.random.uniform(key, (2,), jnp.float32, jnp.asarray([left, low]), jnp.asarray([right, high]))
