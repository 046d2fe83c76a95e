"""What a result of a continuous game gives for a changed one."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from small_continuous_games import AWAY, HOME, Line, LineState, OfCat, line_problem, near, unlearned
from small_games import counted_compilations

import gsiirl
from gsiirl import InputError
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.front_door.continuous_result import LearnedTransitionReward
from gsiirl.problems.continuous_problem import single_precision
from gsiirl.rewards.continuous import AbstractTransitionFeatures, NetworkReward
from gsiirl.types import Sides, Transition

RESULT = unlearned()
STEPS = 6


class OtherWay(AbstractTransitionFeatures):
    """The features of the cat, the last one first."""

    names: tuple[str, ...] = eqx.field(static=True, default=("away", "home"))

    def __call__(self, transition: Transition) -> jax.Array:
        return -jnp.stack([(AWAY - transition.following.cat) ** 2, (HOME - transition.following.cat) ** 2])


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


def test_where_nothing_but_the_goal_matters_the_policy_heads_for_the_new_one_and_what_heads_there_is_gone_on_with():
    # Nearer is better at once and later: as far as a step reaches, and no farther.
    goal = -0.5
    changed = line_problem(
        own_reward=lambda seen: -((goal - seen.following.robot) ** 2), dependent_value=None, dependent_features=None
    )
    policy = RESULT.policy_for(changed, training_steps=1500)
    np.testing.assert_allclose(first_actions(policy), np.clip((goal - ROBOTS) / 0.3, -1.0, 1.0), atol=0.25)
    again = unlearned(policy=policy).policy_for(changed, training_steps=2)
    np.testing.assert_allclose(first_actions(again), first_actions(policy), atol=0.1)


def test_the_value_of_the_changed_problem_is_not_read_and_the_game_is_its_own():
    policy = RESULT.policy_for(line_problem(), training_steps=STEPS)
    assert_same(
        RESULT.policy_for(line_problem(dependent_value=lambda seen: 7.0 * near(seen)), training_steps=STEPS), policy
    )
    longer = RESULT.policy_for(line_problem(game=Line(horizon=5)), training_steps=STEPS)
    assert any(np.abs(one - other).max() > 1e-4 for one, other in zip(numbers(longer), numbers(policy), strict=True))


def test_weights_are_taken_along_by_name_and_in_reward_units():
    same = RESULT.policy_for(line_problem(), training_steps=STEPS)
    other = line_problem(expert_features=OtherWay(), expert_scale=4.0, dependent_scale=6.0)
    assert_same(RESULT.policy_for(other, training_steps=STEPS), same, tolerance=1e-5)


@pytest.mark.slow
def test_a_reward_that_is_a_network_is_taken_along_as_it_is():
    problem = line_problem(expert_features=NetworkReward(features=OfCat(), scale=2.0, hidden=2), expert_scale=None)
    size = len(problem.expert_reward.names)
    learned = LearnedTransitionReward(problem.expert_reward, np.linspace(-0.3, 0.3, size, dtype=np.float32))
    result = unlearned(problem=problem, expert_reward=learned)
    policy = result.policy_for(problem, training_steps=STEPS)
    # The scale that was learned with holds.
    scaled = line_problem(expert_features=NetworkReward(features=OfCat(), scale=9.0, hidden=2), expert_scale=None)
    assert_same(result.policy_for(scaled, training_steps=STEPS), policy)
    with pytest.raises(InputError, match="problem: its reward of the expert features has other weights"):
        result.policy_for(line_problem(), training_steps=STEPS)


def test_the_same_seed_gives_the_same_policy_and_another_goal_compiles_nothing_anew():
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
        (line_problem(game=Watched()), "problem.game: has observations of 1 and 3 numbers, actions of 1 and 1"),
    ):
        with pytest.raises(InputError, match=words):
            RESULT.policy_for(problem)
    with pytest.raises(InputError, match="training_steps"):
        RESULT.policy_for(line_problem(), training_steps=0)
    with pytest.raises(InputError, match="seed"):
        RESULT.policy_for(line_problem(), -1)
