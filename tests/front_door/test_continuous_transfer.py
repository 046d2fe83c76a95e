"""What a result of a continuous game gives for a changed one."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from small_continuous_games import AWAY, HOME, PROBLEM, Line, LineState, OfCat, line_problem, near, unlearned
from small_games import counted_compilations

import gsiirl
from gsiirl import InputError
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.front_door.continuous_result import LearnedTransitionReward
from gsiirl.front_door.transfer import taken_along
from gsiirl.problems.continuous_problem import random_steps, single_precision
from gsiirl.rewards.continuous import AbstractTransitionFeatures, NetworkReward
from gsiirl.types import Sides, Transition

RESULT = unlearned()
STEPS = 6


class OtherWay(AbstractTransitionFeatures):
    """The features of the cat, the last one first."""

    names: tuple[str, ...] = eqx.field(static=True, default=("away", "home"))

    def __call__(self, transition: Transition) -> jax.Array:
        return -jnp.stack([(AWAY - transition.following.cat) ** 2, (HOME - transition.following.cat) ** 2])


class OnlyHome(AbstractTransitionFeatures):
    """One of the two."""

    names: tuple[str, ...] = eqx.field(static=True, default=("home",))

    def __call__(self, transition: Transition) -> jax.Array:
        return -((HOME - transition.following.cat) ** 2)[None]


class Mirrored(OfCat):
    """The features of a cat on the other side."""

    def __call__(self, transition: Transition) -> jax.Array:
        return super().__call__(eqx.tree_at(lambda seen: seen.following.cat, transition, -transition.following.cat))


class Dull(AbstractTransitionFeatures):
    """Something else about the cat."""

    names: tuple[str, ...] = eqx.field(static=True, default=("home", "sleep"))

    def __call__(self, transition: Transition) -> jax.Array:
        return jnp.stack([transition.following.cat, transition.following.cat])


class Watched(Line):
    """The robot sees itself alone."""

    def observe(self, state: LineState) -> Sides[jax.Array]:
        return Sides(state.robot[None], super().observe(state).expert)


def numbers(policy: PolicyNetwork) -> list[Any]:
    return [np.asarray(leaf) for leaf in jax.tree.leaves(policy)]


def assert_same(one: PolicyNetwork, other: PolicyNetwork, tolerance: float = 0.0) -> None:
    for mine, theirs in zip(numbers(one), numbers(other), strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=tolerance)


ROBOTS = jnp.linspace(-0.5, 0.5, 5, dtype=jnp.float32)


def first_actions(policy: PolicyNetwork) -> np.ndarray:
    """Of the robot at `ROBOTS`."""
    with single_precision():
        seen = [Line().observe(LineState(robot, jnp.float32(0.1))).learner for robot in ROBOTS]
        return np.array([float(policy(each, jnp.float32(0.0))[0]) for each in seen])


GOAL = -0.5
MOVED = line_problem(own_reward=lambda seen: -((GOAL - seen.following.robot) ** 2))
ALONE = LearnedTransitionReward(PROBLEM.dependent_reward, np.zeros(1, np.float32))
"""No r_ld."""


@pytest.fixture(scope="module")
def heading() -> PolicyNetwork:
    """What nothing but its own goal matters to."""
    return unlearned(dependent_reward=ALONE).policy_for(MOVED, training_steps=1500)


def test_where_nothing_but_the_goal_matters_the_policy_heads_for_the_new_one(heading: PolicyNetwork):
    # Nearer is better at once and later: as far as a step reaches, and no farther.
    np.testing.assert_allclose(first_actions(heading), np.clip((GOAL - ROBOTS) / 0.3, -1.0, 1.0), atol=0.25)


@pytest.mark.slow
def test_the_search_begins_from_what_the_result_holds(heading: PolicyNetwork):
    # Two steps lead hardly away from what heads there already.
    again = unlearned(dependent_reward=ALONE, policy=heading).policy_for(MOVED, training_steps=2)
    np.testing.assert_allclose(first_actions(again), first_actions(heading), atol=0.1)


@pytest.mark.slow
def test_the_value_of_the_changed_problem_is_not_read():
    policy = RESULT.policy_for(line_problem(), training_steps=STEPS)
    assert_same(
        RESULT.policy_for(line_problem(dependent_value=lambda seen: 7.0 * near(seen)), training_steps=STEPS), policy
    )


@pytest.mark.slow
@pytest.mark.parametrize("changes", [{"game": Line(horizon=5)}, {"discount": 0.2}])
def test_the_game_and_the_discount_are_those_of_the_changed_problem(changes: dict[str, Any]):
    policy = RESULT.policy_for(line_problem(), training_steps=STEPS)
    other = RESULT.policy_for(line_problem(**changes), training_steps=STEPS)
    assert any(np.abs(one - two).max() > 1e-4 for one, two in zip(numbers(other), numbers(policy), strict=True))


@single_precision()
def test_weights_are_taken_along_by_name_and_in_reward_units():
    steps = random_steps(Line())
    for wanted in (
        line_problem(expert_features=OtherWay(), expert_scale=4.0).expert_reward,
        line_problem(expert_features=OnlyHome()).expert_reward,
    ):
        taken = taken_along("expert", wanted, PROBLEM.expert_reward, RESULT.expert_reward.parameters)
        for place in range(4):
            step = jax.tree.map(lambda leaf: leaf[place], steps)  # noqa: B023 (called at once)
            features = -np.array([(HOME - step.following.cat) ** 2, (AWAY - step.following.cat) ** 2])
            weights = [RESULT.expert_reward[name] if name in wanted.names else 0.0 for name in ("home", "away")]
            np.testing.assert_allclose(taken(step), np.dot(weights, features), rtol=1e-5)


@single_precision()
def test_a_reward_that_is_a_network_is_taken_along_with_its_settings_and_new_features():
    known = NetworkReward(features=OfCat(), scale=2.0, hidden=2)
    parameters = np.linspace(-0.3, 0.3, len(known.names), dtype=np.float32)
    mirrored = taken_along("expert", NetworkReward(features=Mirrored(), scale=2.0, hidden=2), known, parameters)
    step = jax.tree.map(lambda leaf: leaf[0], random_steps(Line()))
    there = eqx.tree_at(lambda seen: seen.following.cat, step, -step.following.cat)
    np.testing.assert_allclose(mirrored(step), known(jnp.asarray(parameters), there), rtol=1e-5)
    assert abs(float(mirrored(step)) - float(known(jnp.asarray(parameters), step))) > 1e-3
    for other, words in (
        (NetworkReward(features=OfCat(), scale=9.0, hidden=2), "differs from the reward that was learned in: scale$"),
        (NetworkReward(features=OfCat(), scale=2.0, hidden=3), "names of weights, hidden; give a NetworkReward like"),
        (PROBLEM.expert_reward, "problem.expert_features: .* kind, names of weights, hidden, reach"),
    ):
        with pytest.raises(InputError, match=words.removesuffix("$")):
            taken_along("expert", other, known, parameters)


def test_the_same_seed_gives_the_same_policy_and_another_one_compiles_nothing_anew():
    problem = line_problem()
    policy = RESULT.policy_for(problem, 3, training_steps=STEPS)
    with counted_compilations() as compiled:
        assert_same(RESULT.policy_for(problem, 3, training_steps=STEPS), policy)
        RESULT.policy_for(problem, 4, training_steps=STEPS)
    assert not compiled


def test_what_cannot_be_is_refused_in_one_line():
    game = gsiirl.games.TabularGame.from_arrays(np.ones((1, 2, 2, 1)), initial=[1.0], horizon=1)
    finite = gsiirl.Problem(game, dependent_value=np.ones((1, 2, 2)), discount=1.0, temperature=0.1)
    for problem, words in (
        (finite, "problem: is Problem"),
        (line_problem(expert_features=Dull()), "problem: its expert_features have a 'sleep', of which nothing"),
        (line_problem(dependent_value=None, dependent_features=None), "problem.dependent_features: is None"),
        (line_problem(game=Watched()), "problem.game: has observations of 1 and 3 numbers, actions of 1 and 1"),
    ):
        with pytest.raises(InputError, match=words):
            RESULT.policy_for(problem)
    with pytest.raises(InputError, match="training_steps"):
        RESULT.policy_for(line_problem(), training_steps=0)
    with pytest.raises(InputError, match="seed"):
        RESULT.policy_for(line_problem(), 2**31)
