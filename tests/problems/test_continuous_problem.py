"""What a problem of a continuous game holds, and what is refused in one line."""

from collections.abc import Callable, Iterator
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import jaxtyping
import numpy as np
import pytest
from small_continuous_games import (
    PROBLEM,
    SETTINGS,
    Line,
    LineState,
    OfCat,
    OfRobot,
    cat,
    cat_reward,
    dependent_value,
    line_learner,
    line_problem,
    own_reward,
    unlearned,
)
from small_games import finite_game, problem_of, tabular

import gsiirl
from gsiirl import InputError
from gsiirl.problems.continuous_problem import ContinuousProblem, random_steps, single_precision
from gsiirl.rewards.continuous import LinearTransitionReward, NetworkReward
from gsiirl.types import Sides


@pytest.fixture(autouse=True)
def _as_a_user_has_it() -> Iterator[None]:
    """Without the types that the tests check at run time: what is refused is refused by the library itself."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


class Stretching(Line):
    def step(self, state: LineState, actions: Sides[jax.Array]) -> LineState:
        return LineState(state.robot + 0.3 * actions.learner, state.cat)


class Blind(Line):
    def observe(self, state: LineState) -> Sides[jax.Array]:
        return Sides(state.robot, jnp.stack([state.cat]))


class Unseen(Line):
    def observe(self, state: LineState) -> Any:
        return jnp.stack([state.robot, state.cat])


class Still(Line):
    @property
    def action_size(self) -> Sides[int]:
        return Sides(1, 0)


class Unnamed(OfCat):
    names: tuple[str, ...] = eqx.field(static=True, default=("home", "home"))


class Few(OfCat):
    names: tuple[str, ...] = eqx.field(static=True, default=("home",))


class Endless(OfCat):
    def __call__(self, transition: Any) -> jax.Array:
        return jnp.log(-jnp.ones(2))


LINE = LineState(jnp.zeros(()), jnp.zeros(()))

WRONG: dict[str, tuple[str, Callable[[], object]]] = {
    # The game.
    "a game that is none": ("game", lambda: ContinuousProblem(3, expert_features=OfCat())),
    "a finite game": ("game", lambda: ContinuousProblem(tabular(finite_game()), expert_features=OfCat())),
    "a game of no steps": ("game.horizon", lambda: line_problem(game=Line(horizon=0))),
    "a side without actions": ("game.action_size.expert", lambda: line_problem(game=Still())),
    "a step that makes another kind of state": ("game.step", lambda: line_problem(game=Stretching())),
    "an observation that is a number": ("game.observe, learner", lambda: line_problem(game=Blind())),
    "one observation for both": ("game.observe", lambda: line_problem(game=Unseen())),
    # The rewards.
    "an own reward that is a number": ("own_reward", lambda: line_problem(own_reward=1.0)),
    "an own reward that is an array": ("own_reward", lambda: line_problem(own_reward=np.zeros(3))),
    "an own reward that is a vector": (
        "own_reward",
        lambda: line_problem(own_reward=lambda seen: seen.actions.learner),
    ),
    "an own reward of text": ("own_reward", lambda: line_problem(own_reward=lambda seen: "much")),
    "an own reward that is not finite": ("own_reward", lambda: line_problem(own_reward=lambda seen: jnp.log(-1.0))),
    "a value of two numbers": ("dependent_value", lambda: line_problem(dependent_value=lambda seen: (1.0, 2.0))),
    "a value that counts": ("dependent_value", lambda: line_problem(dependent_value=lambda seen: jnp.asarray(1))),
    # The features.
    "no features of the expert's reward": ("expert_features", lambda: line_problem(expert_features=None)),
    "features that are a function": ("expert_features", lambda: line_problem(expert_features=cat_reward)),
    "features of fewer names": ("expert_features", lambda: line_problem(expert_features=Few())),
    "features of one name": ("expert_features.names", lambda: line_problem(expert_features=Unnamed())),
    "features that are not finite": ("expert_features", lambda: line_problem(expert_features=Endless())),
    "a value without features": ("dependent_features", lambda: line_problem(dependent_features=None)),
    "features for the fit that are an array": (
        "dependent_features",
        lambda: line_problem(dependent_features=np.zeros(3)),
    ),
    # The numbers.
    "a discount above 1": ("discount", lambda: line_problem(discount=1.5)),
    "a scale of 0": ("expert_scale", lambda: line_problem(expert_scale=0.0)),
    "a scale below 0": ("dependent_scale", lambda: line_problem(dependent_scale=-1.0)),
    "a scale that is NaN": ("expert_scale", lambda: line_problem(expert_scale=float("nan"))),
    "a scale beside a reward that has one": (
        "expert_scale",
        lambda: line_problem(expert_features=NetworkReward(features=OfCat(), scale=1.0), expert_scale=2.0),
    ),
    # The expert.
    "an expert without a reward": ("reward", lambda: cat(reward=None)),
    "an expert whose reward is a vector": ("reward", lambda: cat(reward=OfCat())),
    "an expert of a finite game": ("game", lambda: cat(game=tabular(finite_game()))),
    "an expert of no discount": ("discount", lambda: cat(discount=0)),
    "an expert of half a step": ("steps", lambda: cat(steps=0.5)),
    "an expert that does not learn": ("learning_rate", lambda: cat(learning_rate=0.0)),
    # The learner.
    "networks of no width": ("hidden", lambda: line_learner(hidden=0)),
    "no steps of the solver": ("solver_steps", lambda: line_learner(solver_steps=0)),
    "settling backwards": ("settling_steps", lambda: line_learner(settling_steps=-1)),
    "a rate of text": ("learning_rate", lambda: line_learner(learning_rate="fast")),
    "noise below 0": ("noise", lambda: line_learner(noise=-0.1)),
    "no iteration": ("iterations", lambda: line_learner().fit(cat(), iterations=0)),
    "no episodes": ("trajectories", lambda: line_learner().fit(cat(), 1, 0)),
    "a seed below 0": ("seed", lambda: line_learner().fit(cat(), 1, 1, seed=-1)),
    "no seeds": ("seeds", lambda: line_learner().fit(cat(), 1, 1, seeds=0)),
    "an expert that shows nothing": ("expert", lambda: line_learner().fit(object())),  # pyright: ignore[reportArgumentType]
    "an expert that lives in a finite game": (
        "expert",
        lambda: line_learner().fit(gsiirl.RespondingExpert(tabular(finite_game()), finite_game().expert, 0.3, 0.9)),
    ),
    # The result.
    "a step after the end": ("t", lambda: unlearned().act(LINE, 3)),
    "a step before the start": ("t", lambda: unlearned().act(LINE, -1)),
    "half a step": ("t", lambda: unlearned().act(LINE, 0.5)),  # pyright: ignore[reportArgumentType]
    "a state that is a number": ("state", lambda: unlearned().act(0, 0)),
    "a state of two robots": ("state", lambda: unlearned().act(LineState(jnp.zeros(2), jnp.zeros(())), 0)),
    "no true reward": ("expert_reward", lambda: unlearned().evaluate(None)),  # pyright: ignore[reportArgumentType]
    "no training": ("training_steps", lambda: unlearned().evaluate(cat_reward, training_steps=0)),
    "no evaluation": ("evaluation_episodes", lambda: unlearned().evaluate(cat_reward, evaluation_episodes=0)),
    "an expert of a longer game": ("expert", lambda: line_learner().fit(cat(game=Line(horizon=4)))),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_is_refused_in_one_line_that_names_it(case: str) -> None:
    argument, call = WRONG[case]
    with pytest.raises(InputError) as refused:
        call()
    assert refused.value.field == argument
    assert "\n" not in str(refused.value)
    assert refused.value.mend


def test_a_problem_and_a_learner_are_of_the_kind_of_the_game() -> None:
    finite, continuous = problem_of(finite_game()), PROBLEM
    assert type(finite) is gsiirl.Problem
    assert type(continuous) is ContinuousProblem
    assert type(gsiirl.GSIIRL(finite)) is gsiirl.GSIIRL
    assert type(gsiirl.GSIIRL(continuous)) is type(line_learner())
    assert type(gsiirl.GSIIRL(problem=continuous)) is type(line_learner())


def test_a_problem_holds_what_may_be_learned_in_its_scales() -> None:
    problem = PROBLEM
    assert isinstance(problem.expert_reward, LinearTransitionReward)
    assert (problem.expert_reward.scale, problem.dependent_reward.scale) == (2.0, 3.0)
    assert problem.expert_reward.names == ("home", "away")
    assert (problem.own_reward, problem.dependent_value) == (own_reward, dependent_value)
    network = NetworkReward(features=OfCat(), scale=1.5)
    assert line_problem(expert_features=network, expert_scale=None).expert_reward is network


def test_what_is_left_out_is_zero() -> None:
    problem = gsiirl.Problem(Line(), expert_features=OfCat())
    seen = jax.tree.map(lambda leaf: leaf[0], random_steps(Line()))
    with single_precision():
        rewards = problem.true_rewards(cat_reward)
        assert float(rewards.learner(seen)) == 0.0
        assert float(rewards.expert(seen)) == pytest.approx(float(cat_reward(seen)))
    assert problem.discount == 0.95
    assert problem.dependent_reward.names == ("nothing",)


def test_a_problem_and_a_learner_say_what_they_are_in_one_line() -> None:
    assert repr(PROBLEM) == "ContinuousProblem(Line, 1 and 1 actions, 3 steps, 2 weights)"
    assert repr(line_learner()) == f"ContinuousGSIIRL({PROBLEM!r})"
    assert set(SETTINGS) <= set(vars(line_learner()))


def test_features_for_the_fit_alone_are_no_contradiction() -> None:
    problem = line_problem(dependent_value=None, dependent_features=OfRobot())
    assert problem.dependent_reward.names == ("apart",)
