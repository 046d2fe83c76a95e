"""One small continuous game for the tests of its front door: two points on a line."""

from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import polars

import gsiirl
from gsiirl.front_door.continuous_fit import ContinuousGSIIRL
from gsiirl.front_door.continuous_result import ContinuousResult, LearnedTransitionReward
from gsiirl.games import AbstractContinuousGame
from gsiirl.problems.continuous_problem import ContinuousProblem, single_precision
from gsiirl.rewards.continuous import AbstractTransitionFeatures
from gsiirl.types import Sides, Transition

# As a user would have them, in whatever precision JAX is set to: here in double.
DOCK, HOME, AWAY = jnp.array([0.5, 1.0, -1.0])
SETTINGS: dict[str, Any] = {
    "hidden": 4,
    "batch": 4,
    "learning_rate": 0.01,
    "solver_steps": 2,
    "inner_steps": 2,
    "first_inner_steps": 3,
    "remembered": 2,
    "compared": 3,
    "cloning_steps": 3,
    "model_response_steps": 2,
}
ITERATIONS, TRAJECTORIES = 4, 5


class LineState(eqx.Module):
    """Where both are."""

    robot: jax.Array
    cat: jax.Array


class Line(AbstractContinuousGame[LineState]):
    """Each walks at most 0.3 in a step."""

    horizon: int = eqx.field(static=True, default=3)

    @property
    def action_size(self) -> Sides[int]:
        return Sides(1, 1)

    def reset(self, key: jax.Array) -> LineState:
        robot, cat = jax.random.uniform(key, (2,), minval=-0.5, maxval=0.5)
        return LineState(robot, cat)

    def step(self, state: LineState, actions: Sides[jax.Array]) -> LineState:
        return LineState(state.robot + 0.3 * actions.learner[0], state.cat + 0.3 * actions.expert[0])

    def observe(self, state: LineState) -> Sides[jax.Array]:
        return Sides(jnp.stack([state.robot, state.cat]), jnp.stack([state.cat, state.robot, state.cat**2]))


class OfCat(AbstractTransitionFeatures):
    """How near the cat is to its home, and to another place."""

    names: tuple[str, ...] = eqx.field(static=True, default=("home", "away"))

    def __call__(self, transition: Transition) -> jax.Array:
        cat = transition.following.cat
        return -jnp.stack([(HOME - cat) ** 2, (AWAY - cat) ** 2])


class OfRobot(AbstractTransitionFeatures):
    """How near the two are to each other."""

    names: tuple[str, ...] = eqx.field(static=True, default=("apart",))

    def __call__(self, transition: Transition) -> jax.Array:
        return -near(transition)[None]


def near(seen: Transition) -> jax.Array:
    return jnp.exp(-((seen.following.robot - seen.following.cat) ** 2))


def own_reward(seen: Transition) -> jax.Array:
    return -((DOCK - seen.following.robot) ** 2)


def dependent_value(seen: Transition) -> jax.Array:
    return -0.5 * near(seen)


def cat_reward(seen: Transition) -> jax.Array:
    return -((HOME - seen.following.cat) ** 2)


def line_problem(**changes: Any) -> ContinuousProblem:
    """What the learner is told of it."""
    arguments: dict[str, Any] = {
        "game": Line(),
        "own_reward": own_reward,
        "dependent_value": dependent_value,
        "discount": 0.9,
        "expert_features": OfCat(),
        "dependent_features": OfRobot(),
        "expert_scale": 2.0,
        "dependent_scale": 3.0,
    } | changes
    front_door: Any = gsiirl.Problem
    return front_door(**arguments)


PROBLEM = line_problem()


def line_learner(**changes: Any) -> ContinuousGSIIRL:
    """The learner of the game, with small networks and few steps."""
    front_door: Any = gsiirl.GSIIRL
    return front_door(PROBLEM, **(SETTINGS | changes))


def cat(**changes: Any) -> gsiirl.ContinuousRespondingExpert:
    """The expert that lives in it."""
    arguments: dict[str, Any] = {
        "game": Line(),
        "reward": cat_reward,
        "discount": 0.9,
        "iterations": ITERATIONS,
        "steps": 5,
        "first_steps": 20,
        "batch": 4,
        "hidden": 4,
        "learning_rate": 0.05,
    } | changes
    return gsiirl.ContinuousRespondingExpert(**arguments)


def unlearned(seed: int = 0, **changes: Any) -> ContinuousResult:
    """A result that no run came to: random policies and weights."""
    learner = line_learner()
    with single_precision():
        policies = learner.solver(1, 0.1).init(jax.random.key(seed))
    made: dict[str, Any] = {
        "problem": PROBLEM,
        "seed": seed,
        "trajectories": 20,
        "policy": policies.learner.policy,
        "expert_policy": policies.expert.policy,
        "expert_reward": LearnedTransitionReward(PROBLEM.expert_reward, np.array([0.6, -0.8 + seed], np.float32)),
        "dependent_reward": LearnedTransitionReward(PROBLEM.dependent_reward, np.array([0.5], np.float32)),
        "history": polars.DataFrame({"iteration": [1]}),
        "true_returns": learner.true_returns,
        "solver": partial(learner.solver, last_rate=0.02),
    }
    return ContinuousResult(**(made | changes))
