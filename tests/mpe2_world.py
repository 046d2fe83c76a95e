"""The state of mpe2's world as a state of our port."""

from typing import Any

import jax.numpy as jnp

from gsiirl.games import DeceptionState
from gsiirl.types import Sides


def state_of(world: Any) -> DeceptionState:
    """Where everybody and the landmarks are, and the one target of both sides."""
    goal = next(index for index, each in enumerate(world.landmarks) if each is world.agents[0].goal_a)
    return DeceptionState(
        positions=jnp.asarray([agent.state.p_pos for agent in world.agents], jnp.float32),
        velocities=jnp.asarray([agent.state.p_vel for agent in world.agents], jnp.float32),
        landmarks=jnp.asarray([landmark.state.p_pos for landmark in world.landmarks], jnp.float32),
        targets=Sides(jnp.asarray(goal, jnp.int32), jnp.asarray(goal, jnp.int32)),
    )
