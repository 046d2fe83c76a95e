"""Rewards of the crossing: the robot's own, the true ones, and the features that every algorithm shares.

With p the positions after the step, d = ‖p_r − p_h‖ and v the human's speed as a share of its largest along an axis:

    near(d; w) = exp(−(d/w)²/2)
    r_li = −‖g_r − p_r‖                                     the robot's own: to be at its goal
    r_e  = −‖g_h − p_h‖ − 5 · near(d; 0.1)                  the human: to be at its goal, and no collision
    r_ld = −near(d; 0.2) − 0.1 · exp(−(v/0.3)²/2) − 5 · near(d; 0.1)

r_ld is how the human feels about the robot: uneasy when it is near, put out when held up, hurt by a collision.
The paper gives neither formulas nor weights; these are ours, and smooth, so that solvers can differentiate them.

A collision is d < 0.1 after a step; the safe distance is 0.2.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.games.crossing import CrossingState
from gsiirl.rewards.continuous import AbstractTransitionFeatures, length
from gsiirl.types import Number, Transition

ROBOT_GOAL = (0.0, 0.5)
HUMAN_GOAL = (-0.5, 0.0)
GOAL_RADIUS = 0.05
COLLISION_DISTANCE = 0.1
SAFE_DISTANCE = 0.2
COLLISION_PENALTY = 5.0
SLOW_PENALTY = 0.1
SLOW = 0.3

CENTRES = np.stack(np.meshgrid(np.linspace(-0.7, 0.7, 5), np.linspace(-0.7, 0.7, 5), indexing="ij"), -1).reshape(-1, 2)
"""Places that the features measure distances to, (25, 2): an even grid that holds no goal."""
BLUNT = 0.25
"""Below this distance a distance feature is round, not pointed."""
WIDTHS = (0.1, 0.2, 0.4)
NEAR_UNIT = 40.0
"""Of the human's features of nearness: a small weight of theirs is a high price of being near."""


class HumanFeatures(AbstractTransitionFeatures):
    """What the human may be after: −√(‖p_h − c‖² + 0.25²) for 25 places c, −40 near(d; w) for three widths, −‖a_h‖²."""

    names: tuple[str, ...] = eqx.field(
        static=True,
        default=(
            *(f"at ({x:.2f}, {y:.2f})" for x, y in CENTRES),
            *(f"near within {width}" for width in WIDTHS),
            "effort",
        ),
    )

    def __call__(self, transition: Transition) -> Float[Array, " m"]:
        human = _places(transition).positions.expert
        squares = jnp.sum((human[None, :] - jnp.asarray(CENTRES, jnp.float32)) ** 2, axis=1)
        effort = jnp.sum(transition.actions.expert**2)
        return -jnp.concatenate([jnp.sqrt(squares + BLUNT**2), NEAR_UNIT * nearness(transition), effort[None]])


class RobotFeatures(AbstractTransitionFeatures):
    """How the human may feel about the robot: −near(d; w) for three widths, and −slow."""

    names: tuple[str, ...] = eqx.field(
        static=True, default=(*(f"near within {width}" for width in WIDTHS), "slow human")
    )

    def __call__(self, transition: Transition) -> Float[Array, " m"]:
        return -jnp.concatenate([nearness(transition), slowness(transition)[None]])


def own_reward(transition: Transition, goal: tuple[Number, Number] = ROBOT_GOAL) -> Float[Array, ""]:
    """r_li: minus the robot's distance to its goal."""
    return -length(_places(transition).positions.learner - jnp.asarray(goal, jnp.float32))


def dependent_reward(transition: Transition) -> Float[Array, ""]:
    """r_ld: minus the discomfort that the robot causes the human. The learner can read its values, not its formula."""
    weights = jnp.asarray([COLLISION_PENALTY, 1.0, 0.0], jnp.float32)
    return -jnp.vdot(weights, nearness(transition)) - SLOW_PENALTY * slowness(transition)


def human_reward(transition: Transition) -> Float[Array, ""]:
    """r_e: minus the human's distance to its goal, and the collision penalty."""
    distance = length(_places(transition).positions.expert - jnp.asarray(HUMAN_GOAL, jnp.float32))
    return -distance - COLLISION_PENALTY * nearness(transition)[0]


def nearness(transition: Transition) -> Float[Array, " 3"]:
    """near(d; w) = exp(−(d/w)²/2) for w in `WIDTHS`."""
    places = _places(transition).positions
    square = jnp.sum((places.learner - places.expert) ** 2)
    return jnp.exp(-0.5 * square / jnp.asarray(WIDTHS, jnp.float32) ** 2)


def slowness(transition: Transition) -> Float[Array, ""]:
    """exp(−(v/0.3)²/2), v the human's speed as a share of the largest along an axis."""
    return jnp.exp(-0.5 * jnp.sum(transition.actions.expert**2) / SLOW**2)


def _places(transition: Transition) -> CrossingState:
    return transition.following
