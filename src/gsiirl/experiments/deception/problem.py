"""From a configuration of the deception experiment to the game, the two sides, and the truth that judges them."""

from pathlib import Path

import jax
import jax.numpy as jnp
from jaxtyping import Array, PRNGKeyArray

from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.experiments.continuous.run import learnable_reward, prepare_continuous
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.prepared_run import PreparedRun, Record
from gsiirl.games.deception import Deception, DeceptionState
from gsiirl.problems.continuous_problem import ContinuousProblem
from gsiirl.rewards import deception as rewards
from gsiirl.rewards.continuous import AbstractTransitionReward
from gsiirl.types import Sides, Transition

SCALE = 3.0
"""Of both rewards; a true weight of 1 is 1/3 in the unit ball."""


def prepare(config: DeceptionConfig, saved_game: Path | None = None) -> PreparedRun:
    """The run of a resolved configuration; all of the game is in the configuration."""
    return prepare_continuous(config, build(config))


def build(config: DeceptionConfig) -> ContinuousExperiment:
    """The experiment of a resolved configuration."""
    separate = config.variant == "separate_target"
    game = Deception(config.horizon, separate)
    features = rewards.AdversaryDistances(sign=-1.0)
    expert_reward = learnable_reward(config, features, SCALE)

    def judge_reward(parameters: Array) -> Record:
        return {"target_preference": target_preference(expert_reward, parameters, separate)}

    def anywhere(key: PRNGKeyArray) -> Transition:
        """Everybody anywhere in [−1, 1]², at rest."""
        state = game.reset(key)
        still = Sides(jnp.zeros(4, jnp.float32), jnp.zeros(2, jnp.float32))
        return Transition(state, still, state)

    weights = dict.fromkeys(features.names, 0.0) | {features.names[int(separate)]: 1.0}
    return ContinuousExperiment(
        description={
            "kind": "deception",
            "name": "physical deception",
            "variant": config.variant,
            "horizon": config.horizon,
            "truth": {"expert_reward": weights},
        },
        problem=ContinuousProblem(
            game,
            own_reward=rewards.own_reward,
            dependent_value=rewards.dependent_reward,
            discount=config.discount,
            expert_features=expert_reward,
            dependent_features=rewards.AdversaryDistances(sign=1.0),
            dependent_scale=SCALE,
        ),
        true_expert_reward=rewards.adversary_reward,
        anywhere=anywhere,
        judge_episodes=lambda episodes: {},
        judge_reward=judge_reward,
        paths=paths,
        reward_map=lambda parameters: {},
    )


def target_preference(reward: AbstractTransitionReward, parameters: Array, separate: bool) -> Array:
    """r^θ of standing at the adversary's target less r^θ of standing at the other landmark, in reward units.

    The landmarks are at (±0.5, 0) and everybody else is where it cannot matter which: on the line between them.
    """

    def standing_at(place: Array, target: int) -> Transition:
        middle = jnp.zeros((2, 2), jnp.float32)
        state = DeceptionState(
            positions=jnp.concatenate([place[None], middle]),
            velocities=jnp.zeros((3, 2), jnp.float32),
            landmarks=jnp.asarray([[0.5, 0.0], [-0.5, 0.0]], jnp.float32),
            targets=Sides(jnp.asarray(target), jnp.asarray(1 - target if separate else target)),
        )
        still = Sides(jnp.zeros(4, jnp.float32), jnp.zeros(2, jnp.float32))
        return Transition(state, still, state)

    at_target, elsewhere = jnp.asarray([0.5, 0.0], jnp.float32), jnp.asarray([-0.5, 0.0], jnp.float32)
    if separate:
        at_target, elsewhere = elsewhere, at_target
    return reward(parameters, standing_at(at_target, 0)) - reward(parameters, standing_at(elsewhere, 0))


def paths(episodes: Transition) -> dict[str, Array]:
    """Positions of all three from the start to the end, the landmarks, and each side's target."""
    first: DeceptionState = jax.tree.map(lambda leaf: leaf[:, :1], episodes.state)
    places = jnp.concatenate([first.positions, episodes.following.positions], axis=1)
    shape = places.shape[:2]
    columns = {}
    for index, name in enumerate(("adversary", "agent_0", "agent_1")):
        columns |= {f"{name}_x": places[:, :, index, 0], f"{name}_y": places[:, :, index, 1]}
    for index in range(2):
        landmark = jnp.broadcast_to(first.landmarks[:, :, index], (*shape, 2))
        columns |= {f"landmark_{index}_x": landmark[..., 0], f"landmark_{index}_y": landmark[..., 1]}
    for name, target in (("target", first.targets.learner), ("expert_target", first.targets.expert)):
        columns[name] = jnp.broadcast_to(target, shape).astype(places.dtype)
    return columns
