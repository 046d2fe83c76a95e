"""Demonstrations of a continuous game: their types, whether the game can have made them, and the learner's policy."""

import dataclasses
import re
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from small_continuous_games import Line, LineState

from gsiirl import InputError
from gsiirl.demonstrations.continuous import away_from_steps, checked, doubts
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.problems.continuous_problem import single_precision
from gsiirl.types import Sides, Transition

GAME = Line()


def shown(number: int = 5, **changes: Any) -> Transition:
    """Demonstrations of the game, or with other arrays."""
    shape = (number, GAME.horizon)
    arrays: dict[str, Any] = {
        "robot": np.zeros(shape),
        "cat": np.zeros(shape),
        "action": np.zeros((*shape, 1)),
    } | changes
    state = LineState(arrays["robot"], arrays["cat"])
    return Transition(state, Sides(np.zeros((*shape, 1)), arrays["action"]), state)


@pytest.mark.parametrize(
    ("demonstrations", "field"),
    [
        ("nothing", "demonstrations"),
        (dataclasses.replace(shown(), state=np.zeros((5, 3))), "demonstrations"),
        (shown(number=4), "demonstrations.state.robot"),
        (shown(cat=np.zeros((5, 2))), "demonstrations.state.cat"),
        (shown(cat=np.full((5, 3), np.nan)), "demonstrations.state.cat"),
        (shown(robot=np.full((5, 3), "here")), "demonstrations.state.robot"),
        (shown(action=np.zeros((5, 3, 2))), "demonstrations.actions.expert"),
        (shown(action=np.full((5, 3, 1), -1.5)), "demonstrations.actions.expert"),
    ],
)
def test_demonstrations_that_do_not_fit_the_game_are_refused(demonstrations: Any, field: str) -> None:
    with pytest.raises(InputError) as refused:
        checked(demonstrations, 5, GAME)
    assert refused.value.field == field
    assert "\n" not in str(refused.value)


def test_demonstrations_get_the_types_of_the_game() -> None:
    with single_precision():
        seen = checked(shown(cat=np.ones((5, 3), np.int64)), 5, GAME)
    assert {leaf.dtype.name for leaf in jax.tree.leaves(seen)} == {"float32"}
    np.testing.assert_array_equal(seen.state.cat, 1.0)


def left(seen: jax.Array, time: jax.Array) -> jax.Array:
    return -0.5 * jnp.ones(1)


def lived() -> Transition:
    """Episodes that the game made: the robot goes left, the cat right, at half and at full speed."""
    with single_precision():
        policies = Sides(left, lambda seen, time: jnp.ones(1))
        return episodes_from(GAME, policies, initial_states(GAME, jax.random.key(0), 4))


def recorded(state: LineState | None = None, actions: Any = None, following: LineState | None = None) -> Transition:
    """What was lived, with something recorded otherwise."""
    seen = lived()
    return Transition(state or seen.state, actions or seen.actions, following or seen.following)


def moved(state: LineState, by: float) -> LineState:
    return dataclasses.replace(state, cat=state.cat + by)


def test_episodes_that_the_game_made_are_the_games() -> None:
    with single_precision():
        off, _ = away_from_steps(lived(), GAME)
    assert off < 1e-4


@pytest.mark.parametrize(
    ("other", "field", "said"),
    [
        # Learner and expert swapped.
        (
            lambda seen: recorded(actions=Sides(seen.actions.expert, seen.actions.learner)),
            "demonstrations.following.",
            "Sides(learner, expert)",
        ),
        # The state before, recorded once more as that after.
        (lambda seen: recorded(following=seen.state), "demonstrations.state.", "is not where step"),
        # Another cat: a step of the game would have taken it elsewhere.
        (
            lambda seen: recorded(actions=Sides(seen.actions.learner, -seen.actions.expert)),
            "demonstrations.following.cat",
            "away from where the game's step ends",
        ),
        (
            lambda seen: recorded(state=moved(seen.state, 0.5), following=moved(seen.following, -0.5)),
            "demonstrations.state.cat",
            "of episode",
        ),
    ],
)
def test_episodes_that_the_game_cannot_have_made_are_refused(
    other: Callable[[Transition], Transition], field: str, said: str
) -> None:
    with single_precision(), pytest.raises(InputError) as refused:
        away_from_steps(other(lived()), GAME)
    assert refused.value.field.startswith(field)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("slower", "said"), [((1.0, 0.9), r"cat ends 1\d%"), ((0.9, 1.0), r"robot ends 1\d%")])
def test_episodes_of_a_world_that_is_nearly_the_game_are_doubted(slower: tuple[float, float], said: str) -> None:
    seen = lived()
    learner, expert = slower
    noted = recorded(actions=Sides(learner * seen.actions.learner, expert * seen.actions.expert))
    with single_precision():
        doubt = doubts(noted, left, GAME)
        assert not doubts(seen, left, GAME)
    assert list(doubt) == ["following"]
    assert re.match(rf"demonstrations\.following\.{said} of what moves", doubt["following"])


def test_episodes_of_another_learners_policy_are_doubted() -> None:
    with single_precision():
        said = doubts(lived(), lambda seen, time: left(seen, time) + 0.2 + 0.1 * time, GAME)
    # 0.2 + 0.1 t/3 on average over t = 0, 1, 2.
    assert said["learner"].startswith(
        "demonstrations.actions.learner are 0.23 on average away from those of the policy"
    )


def test_a_state_that_stands_still_but_for_rounding_is_no_fault() -> None:
    seen = lived()
    still = Sides(jnp.zeros_like(seen.actions.learner), jnp.zeros_like(seen.actions.expert))
    where = jax.tree.map(lambda leaf: jnp.broadcast_to(leaf[:, :1], leaf.shape), seen.state)
    with single_precision():
        rounded = jax.tree.map(lambda leaf: np.nextafter(leaf, np.float32(9)), where)
        assert not doubts(Transition(where, still, rounded), lambda seen, time: jnp.zeros(1), GAME)


@pytest.mark.parametrize("offset", [1e3, 5e4])
def test_far_from_the_origin_other_steps_are_refused_all_the_same(offset: float) -> None:
    seen = lived()
    far = [jax.tree.map(lambda leaf: leaf + offset, each) for each in (seen.state, seen.following)]
    swapped = Sides(seen.actions.expert, seen.actions.learner)
    with single_precision():
        assert not doubts(Transition(far[0], seen.actions, far[1]), left, GAME)
        with pytest.raises(InputError):
            away_from_steps(Transition(far[0], swapped, far[1]), GAME)


def test_a_part_that_moves_by_rounding_alone_is_no_fault() -> None:
    seen = lived()
    still = Sides(seen.actions.learner, jnp.zeros_like(seen.actions.expert))
    zero = jnp.zeros_like(seen.state.cat)
    state = dataclasses.replace(seen.state, cat=zero)
    noisy = dataclasses.replace(seen.following, cat=zero + 1e-9)
    with single_precision():
        assert not doubts(Transition(state, still, noisy), left, GAME)


def test_a_rare_jump_that_comes_elsewhere_is_doubted_and_not_refused() -> None:
    game, number = Line(horizon=1), 200
    still = jnp.zeros((number, 1), jnp.float32)
    state = LineState(still, still)
    once = jnp.zeros((number, 1, 1), jnp.float32).at[0].set(1.0)
    with single_precision():
        said = doubts(
            Transition(state, Sides(jnp.zeros_like(once), once), state), lambda seen, time: jnp.zeros(1), game
        )
    assert said["following"].startswith("demonstrations.following.cat ends 100%")


class Crowd(Line):
    """The same, with a part of the state that is empty or a step that is not finite."""

    def step(self, state: Any, actions: Sides[jax.Array]) -> Any:
        return {"line": super().step(state["line"], actions), "others": state["others"], "odd": 0.0 / state["odd"]}


def test_an_empty_part_is_no_fault_and_a_step_that_is_not_finite_is_the_games() -> None:
    seen = lived()

    def crowd(line: LineState, odd: float) -> dict[str, Any]:
        shape = line.cat.shape
        return {"line": line, "others": jnp.zeros((*shape, 0, 2)), "odd": jnp.full(shape, odd)}

    near, broken = (Transition(crowd(seen.state, odd), seen.actions, crowd(seen.following, 0.0)) for odd in (1e-9, 0.0))
    with single_precision():
        assert away_from_steps(near, Crowd())[0] < 1e-3
        with pytest.raises(InputError, match="has a step that is not finite"):
            away_from_steps(broken, Crowd())


class Car(Line):
    """Both in one array, as many games have it; the cat goes a hundredth as far. Then a count and a flag."""

    def step(self, state: Any, actions: Sides[jax.Array]) -> Any:
        way = jnp.stack([0.3 * actions.learner[0], 0.003 * actions.expert[0]])
        return {"where": state["where"] + way, "count": state["count"] + 1, "late": state["count"] >= 1}


def driven(game: Car, learner: jax.Array, expert: jax.Array) -> Transition:
    """Episodes of the game, from 0; actions (episodes, T, 1)."""
    way = np.concatenate([0.3 * learner, 0.003 * expert], axis=-1)
    count = np.broadcast_to(np.arange(game.horizon), way.shape[:2])
    where = np.cumsum(way, axis=1)
    before = {"where": where - way, "count": count, "late": count >= 2}
    return Transition(before, Sides(learner, expert), {"where": where, "count": count + 1, "late": count >= 1})


@pytest.mark.parametrize("horizon", [1, 3])
def test_each_number_of_an_array_is_measured_by_how_far_it_moves(horizon: int) -> None:
    game, ones = Car(horizon=horizon), jnp.ones((5, horizon, 1), jnp.float32)
    with single_precision():
        assert away_from_steps(driven(game, -0.5 * ones, ones), game)[0] < 1e-4
        turned = dataclasses.replace(driven(game, -0.5 * ones, ones), actions=Sides(-0.5 * ones, -ones))
        with pytest.raises(InputError, match=r"demonstrations\.following\['where'\]\[1\]: ends 200%"):
            away_from_steps(turned, game)
