import jax
import jax.numpy as jnp
import pytest

from gsiirl.experiments.crossing.problem import judge_episodes
from gsiirl.games.crossing import CrossingState
from gsiirl.types import Sides, Transition

ROBOT_GOAL, HUMAN_GOAL = (0.0, 0.5), (-0.5, 0.0)


def episode(robot: list[tuple[float, float]], human: list[tuple[float, float]]) -> Transition:
    """The places after each step; those before it are at the goals and on top of each other, and count for nothing."""
    before = CrossingState(Sides(jnp.tile(jnp.asarray(ROBOT_GOAL), (len(robot), 1)), jnp.zeros((len(human), 2))))
    after = CrossingState(Sides(jnp.asarray(robot), jnp.asarray(human)))
    return Transition(before, Sides(jnp.zeros((len(robot), 2)), jnp.zeros((len(human), 2))), after)


def test_collisions_count_at_any_step_and_arrivals_at_the_last_one() -> None:
    far = (0.4, -0.4)
    episodes = [
        episode([far, ROBOT_GOAL], [(0.4, 0.4), HUMAN_GOAL]),  # both arrive
        episode([(0.0, 0.0), ROBOT_GOAL], [(0.0, 0.099), (0.4, 0.4)]),  # a collision on the way, the robot arrives
        episode([ROBOT_GOAL, far], [(0.0, 0.3), (-0.46, 0.0)]),  # the robot leaves its goal again, the human is near
        episode([far, (0.0, 0.56)], [(0.4, -0.29), (-0.44, 0.0)]),  # no collision at 0.11, and both just miss
    ]
    stacked = jax.tree.map(lambda *each: jnp.stack(each), *episodes)
    found = {name: float(value) for name, value in judge_episodes(stacked).items()}
    assert found == pytest.approx({"collision_rate": 0.25, "goal_rate_robot": 0.5, "goal_rate_human": 0.5})
