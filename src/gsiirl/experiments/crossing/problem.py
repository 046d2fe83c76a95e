"""From a configuration of the crossing experiment to the game, the two sides, and the truth that judges them."""

from pathlib import Path

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.experiments.continuous.run import learnable_reward, prepare_continuous
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.prepared_run import PreparedRun, Record
from gsiirl.games.crossing import HUMAN_START, ROBOT_START, Crossing, CrossingState
from gsiirl.problems.continuous_problem import ContinuousProblem
from gsiirl.rewards import crossing as rewards
from gsiirl.types import Sides, Transition

ARENA = 0.8
"""Positions are judged within this distance of the origin, along each axis."""
GRID = 81
"""Places along an axis on which the learned goal is looked for: 0.02 apart."""
MAP = 33
EXPERT_SCALE, DEPENDENT_SCALE = 1.0, 8.0


def prepare(config: CrossingConfig, saved_game: Path | None = None) -> PreparedRun:
    """The run of a resolved configuration; all of the game is in the configuration."""
    return prepare_continuous(config, build(config))


def build(config: CrossingConfig) -> ContinuousExperiment:
    """The experiment of a resolved configuration."""
    expert_reward = learnable_reward(config, rewards.HumanFeatures(), EXPERT_SCALE)

    def reward_at(parameters: Array, place: Array) -> Array:
        return expert_reward(parameters, standing_at(place))

    def judge_reward(parameters: Array) -> Record:
        places = grid(GRID)
        goal = places[jnp.argmax(jax.vmap(lambda place: reward_at(parameters, place))(places))]
        return {"human_goal_error": jnp.linalg.norm(goal - jnp.asarray(rewards.HUMAN_GOAL, jnp.float32))}

    def reward_map(parameters: Array) -> dict[str, Array]:
        places = grid(MAP)
        return {
            "x": places[:, 0],
            "y": places[:, 1],
            "learned": jax.vmap(lambda place: reward_at(parameters, place))(places),
            "true": jax.vmap(lambda place: rewards.human_reward(standing_at(place)))(places),
        }

    return ContinuousExperiment(
        description={
            "kind": "crossing",
            "name": "crossing",
            "variant": "default",
            "horizon": config.horizon,
            "robot_goal": rewards.ROBOT_GOAL,
            "human_goal": rewards.HUMAN_GOAL,
            "goal_radius": rewards.GOAL_RADIUS,
            "collision_distance": rewards.COLLISION_DISTANCE,
            "safe_distance": rewards.SAFE_DISTANCE,
            "robot_start": ROBOT_START,
            "human_start": HUMAN_START,
            "arena": ((-ARENA, ARENA), (-ARENA, ARENA)),
        },
        problem=ContinuousProblem(
            Crossing(config.horizon),
            own_reward=rewards.own_reward,
            dependent_value=rewards.dependent_reward,
            discount=config.discount,
            expert_features=expert_reward,
            dependent_features=rewards.RobotFeatures(),
            dependent_scale=DEPENDENT_SCALE,
        ),
        true_expert_reward=rewards.human_reward,
        anywhere=anywhere,
        judge_episodes=judge_episodes,
        judge_reward=judge_reward,
        paths=paths,
        reward_map=reward_map,
    )


def judge_episodes(episodes: Transition) -> Record:
    """Shares of episodes with a collision, and with the robot and the human at its goal at the end."""
    places = episodes.following.positions
    distance = jnp.linalg.norm(places.learner - places.expert, axis=-1)

    def arrived(side: Array, goal: tuple[float, float]) -> Array:
        remaining = jnp.linalg.norm(side[:, -1] - jnp.asarray(goal, side.dtype)[None, :], axis=-1)
        return jnp.mean((remaining <= rewards.GOAL_RADIUS).astype(side.dtype))

    return {
        "collision_rate": jnp.mean((jnp.min(distance, axis=1) < rewards.COLLISION_DISTANCE).astype(distance.dtype)),
        "goal_rate_robot": arrived(places.learner, rewards.ROBOT_GOAL),
        "goal_rate_human": arrived(places.expert, rewards.HUMAN_GOAL),
    }


def anywhere(key: PRNGKeyArray) -> Transition:
    """Both anywhere in the arena, with any actions."""
    keys = jax.random.split(key, 4)

    def draw(key: PRNGKeyArray, bound: float) -> Array:
        return jax.random.uniform(key, (2,), jnp.float32, -bound, bound)

    places = CrossingState(Sides(draw(keys[0], ARENA), draw(keys[1], ARENA)))
    return Transition(places, Sides(draw(keys[2], 1.0), draw(keys[3], 1.0)), places)


def standing_at(place: Float[Array, " 2"]) -> Transition:
    """The human stands at `place`, with the robot far away."""
    state = CrossingState(Sides(jnp.full_like(place, 100.0), place))
    still = jnp.zeros_like(place)
    return Transition(state, Sides(still, still), state)


def grid(number: int) -> Float[Array, "points 2"]:
    """An even grid over the arena."""
    axis = jnp.linspace(-ARENA, ARENA, number, dtype=jnp.float32)
    return jnp.stack(jnp.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)


def paths(episodes: Transition) -> dict[str, Array]:
    """Positions of both, from the start to the end."""
    columns = {}
    for side, name in (("learner", "robot"), ("expert", "human")):
        first = getattr(episodes.state.positions, side)[:, :1]
        places = jnp.concatenate([first, getattr(episodes.following.positions, side)], axis=1)
        columns |= {f"{name}_x": places[..., 0], f"{name}_y": places[..., 1]}
    return columns
