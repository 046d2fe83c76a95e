"""What cannot be is refused in one line that begins with the argument's name, before anything is compiled."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import jaxtyping
import numpy as np
import pytest
from small_games import (
    EXPERT_ACTIONS,
    HORIZON,
    JOINT,
    LEARNER_ACTIONS,
    counted_compilations,
    expert_of,
    finite_game,
    made_result,
    problem_of,
    tabular,
)

from gsiirl import GSIIRL, InputError, Problem, RespondingExpert, SimulatedExpert, load
from gsiirl.demonstrations.finite import checked
from gsiirl.equilibria import Logit
from gsiirl.games import DensePayoff, TabularGame
from gsiirl.rewards.linear import IndicatorFeatures, TabularFeatures
from gsiirl.types import Sides, Trajectories

SMALL = finite_game()
ONES = np.ones(JOINT)
TWO = np.stack([ONES, -ONES], -1)
"""Two features."""


@pytest.fixture(autouse=True)
def _unchecked() -> Iterator[None]:
    """Annotations are not checked here: outside the tests nobody but the library itself refuses a wrong type."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


def put(array: np.ndarray, place: tuple[int, ...], value: float) -> np.ndarray:
    """A copy with one entry changed."""
    changed = np.array(array, float)
    changed[place] = value
    return changed


def game(**changes: Any) -> TabularGame:
    return tabular(SMALL, **changes)


def problem(**changes: Any) -> Problem:
    return problem_of(SMALL, **changes)


def expert(**changes: Any) -> RespondingExpert:
    return expert_of(SMALL, **changes)


def fit(expert: Any = None, *arguments: Any, **settings: Any) -> object:
    who = expert_of(SMALL) if expert is None else expert
    return GSIIRL(problem()).fit(who, *arguments, progress=False, **settings)


def pair(successors: Any, probabilities: Any) -> TabularGame:
    """Two states, two actions each."""
    return TabularGame.from_arrays((successors, probabilities), initial=[1.0, 0.0], horizon=2)


def square(**rewards: Any) -> Problem:
    """As many states as actions of either side, so that every axis has the same length."""
    even = TabularGame.from_arrays(np.full((2, 2, 2, 2), 0.5), initial=[0.5, 0.5], horizon=2)
    return Problem(even, temperature=0.3, **rewards)


def seen(**changes: Any) -> Trajectories:
    """Five demonstrations in state 1, or with other arrays."""
    shape = (5, HORIZON)
    arrays = {"states": np.ones(shape, int), "learner": np.zeros(shape, int), "expert": np.zeros(shape, int)}
    arrays |= {"mask": np.ones(shape, bool)} | changes
    given: dict[str, Any] = arrays
    return Trajectories(given["states"], Sides(given["learner"], given["expert"]), given["mask"])


def check(demonstrations: Any) -> object:
    return checked(demonstrations, 5, game())


class Mute:
    """An expert that demonstrates nothing."""


RAGGED = [[1.0, 0.0], [1.0]]
SIMULATED = SimulatedExpert(game(), expert().reward, Logit(0.3), 0.9)

WRONG: dict[str, tuple[str, Callable[[], object]]] = {
    # The dynamics.
    "transitions without a state to follow": ("transitions", lambda: game(transitions=np.ones(JOINT))),
    "transitions to another number of states": ("transitions", lambda: game(transitions=np.full((*JOINT, 4), 0.25))),
    "transitions of no states": ("transitions", lambda: game(transitions=np.ones((0, 2, 3, 0)))),
    "transitions that are NaN": ("transitions", lambda: game(transitions=put(SMALL.transitions, (0, 0, 0, 0), np.nan))),
    "transitions that are infinite": (
        "transitions",
        lambda: game(transitions=put(SMALL.transitions, (0, 0, 0, 0), np.inf)),
    ),
    "transitions below 0": (
        "transitions",
        lambda: game(transitions=put(put(SMALL.transitions, (0, 0, 0, 0), -0.5), (0, 0, 0, 1), 1.5)),
    ),
    "transitions that do not sum to 1": ("transitions", lambda: game(transitions=0.9 * SMALL.transitions)),
    "transitions of text": ("transitions", lambda: game(transitions="somewhere")),
    "transitions that are ragged": ("transitions", lambda: game(transitions=RAGGED)),
    "transitions that are None": ("transitions", lambda: game(transitions=None)),
    "transitions of complex numbers": ("transitions", lambda: game(transitions=SMALL.transitions + 0j)),
    "three arrays of transitions": ("transitions", lambda: game(transitions=(1, 2, 3))),
    "successors and probabilities of two shapes": (
        "transitions",
        lambda: pair(np.zeros((2, 2, 2, 1)), np.full((2, 2, 2, 2), 0.5)),
    ),
    "a successor that is no state": ("successors", lambda: pair(np.full((2, 2, 2, 1), 2), np.ones((2, 2, 2, 1)))),
    "a successor below 0": ("successors", lambda: pair(np.full((2, 2, 2, 1), -1), np.ones((2, 2, 2, 1)))),
    "a successor between two states": ("successors", lambda: pair(np.full((2, 2, 2, 1), 0.5), np.ones((2, 2, 2, 1)))),
    "a probability that is NaN": ("probabilities", lambda: pair(np.zeros((2, 2, 2, 1)), np.full((2, 2, 2, 1), np.nan))),
    "a start of another length": ("initial", lambda: game(initial=[1.0, 0.0])),
    "a start that does not sum to 1": ("initial", lambda: game(initial=[0.5, 0.4, 0.0])),
    "a start below 0": ("initial", lambda: game(initial=[1.5, -0.5, 0.0])),
    "a start of text": ("initial", lambda: game(initial=["a", "b", "c"])),
    "a start that is ragged": ("initial", lambda: game(initial=RAGGED)),
    "no step": ("horizon", lambda: game(horizon=0)),
    "a step and a half": ("horizon", lambda: game(horizon=1.5)),
    "as many steps as True": ("horizon", lambda: game(horizon=True)),
    "as many steps as text": ("horizon", lambda: game(horizon="3")),
    "a mask of the other side's shape": ("learner_actions", lambda: game(learner_actions=EXPERT_ACTIONS)),
    "a mask of whole numbers": ("learner_actions", lambda: game(learner_actions=LEARNER_ACTIONS.astype(int))),
    "a mask that is ragged": ("learner_actions", lambda: game(learner_actions=[[True, True], [True], [True, True]])),
    "a mask that allows nothing": ("expert_actions", lambda: game(expert_actions=np.zeros((3, 3), bool))),
    "an end that is no state": ("terminal", lambda: game(terminal=[3])),
    "an end below 0": ("terminal", lambda: game(terminal=[-1])),
    "an end between two states": ("terminal", lambda: game(terminal=[0.5])),
    "an end of text": ("terminal", lambda: game(terminal="last")),
    "ends that are ragged": ("terminal", lambda: game(terminal=[[0], [1, 2]])),
    "booleans for other states": ("terminal", lambda: game(terminal=[True, False])),
    # The problem.
    "a game that is an array": ("game", lambda: problem(game=SMALL.transitions)),
    "an own reward of the expert's actions": ("own_reward", lambda: problem(own_reward=np.ones((3, 3)))),
    "an own reward of states alone": ("own_reward", lambda: problem(own_reward=np.ones(3))),
    "an own reward that is NaN": ("own_reward", lambda: problem(own_reward=np.full((3, 2), np.nan))),
    "a dependent value of states and own actions": ("dependent_value", lambda: problem(dependent_value=SMALL.own)),
    "a dependent value that would broadcast in a square game": (
        "dependent_value",
        lambda: square(dependent_value=np.ones((2, 2))),
    ),
    "a dependent value for both sides exchanged": (
        "dependent_value",
        lambda: problem(dependent_value=SMALL.dependent.transpose(0, 2, 1)),
    ),
    "a dependent value that is infinite": ("dependent_value", lambda: problem(dependent_value=np.full(JOINT, np.inf))),
    "a dependent value of text": ("dependent_value", lambda: problem(dependent_value="high")),
    "a dependent value of other actions": (
        "dependent_value",
        lambda: problem(dependent_value=DensePayoff(np.ones((3, 3, 3)))),
    ),
    "a dependent value of other states": (
        "dependent_value",
        lambda: problem(dependent_value=DensePayoff(np.ones((4, 2, 3)))),
    ),
    "a discount of 0": ("discount", lambda: problem(discount=0)),
    "a discount above 1": ("discount", lambda: problem(discount=1.2)),
    "a discount of text": ("discount", lambda: problem(discount="high")),
    "a discount for every state": ("discount", lambda: problem(discount=np.full(3, 0.9))),
    "a temperature of 0": ("temperature", lambda: problem(temperature=0)),
    "a temperature below 0": ("temperature", lambda: problem(temperature=-0.1)),
    "a temperature that is NaN": ("temperature", lambda: problem(temperature=float("nan"))),
    "a temperature that is infinite": ("temperature", lambda: problem(temperature=float("inf"))),
    "a temperature of text": ("temperature", lambda: problem(temperature="warm")),
    "a temperature that is an array of text": ("temperature", lambda: problem(temperature=np.array("warm"))),
    "a temperature of True": ("temperature", lambda: problem(temperature=True)),
    "a reward scale of 0": ("reward_scale", lambda: problem(reward_scale=0)),
    "no features": ("expert_features", lambda: problem(expert_features=np.ones((*JOINT, 0)))),
    "an empty mapping of features": ("expert_features", lambda: problem(expert_features={})),
    "features of another shape": ("expert_features", lambda: problem(expert_features=np.ones((3, 3, 2, 1)))),
    "features without an axis of them": ("dependent_features", lambda: problem(dependent_features=ONES)),
    "a feature of another shape": ("expert_features['toll']", lambda: problem(expert_features={"toll": SMALL.own})),
    "a feature that is NaN": ("expert_features['toll']", lambda: problem(expert_features={"toll": np.nan * ONES})),
    "features of the library for another game": (
        "expert_features",
        lambda: problem(expert_features=IndicatorFeatures(shape=(3, 3, 3))),
    ),
    "a table of the library of another shape": (
        "expert_features",
        lambda: problem(expert_features=TabularFeatures(table=np.ones((3, 3, 2, 1)))),
    ),
    "names without features": ("expert_names", lambda: problem(expert_names=["toll"])),
    "names beside a mapping": ("expert_names", lambda: problem(expert_features={"toll": ONES}, expert_names=["toll"])),
    "too few names": ("expert_names", lambda: problem(expert_features=TWO, expert_names=["toll"])),
    "one name twice": ("dependent_names", lambda: problem(dependent_features=TWO, dependent_names=["toll", "toll"])),
    "a name that is no text": ("expert_names", lambda: problem(expert_features=TWO, expert_names=["toll", 1])),
    "a name that is empty": ("expert_names", lambda: problem(expert_features=TWO, expert_names=["toll", ""])),
    "names that are one text": ("expert_names", lambda: problem(expert_features=TWO, expert_names="ab")),
    "names that are a number": ("expert_names", lambda: problem(expert_features=TWO, expert_names=2)),
    # The expert.
    "an expert's game that is an array": ("game", lambda: expert(game=SMALL.transitions)),
    "an expert without a reward": ("reward", lambda: expert(reward=None)),
    "an expert's reward of states and own actions": ("reward", lambda: expert(reward=SMALL.own)),
    "an expert's reward that is NaN": ("reward", lambda: expert(reward=np.full(JOINT, np.nan))),
    "an expert of temperature 0": ("temperature", lambda: expert(temperature=0)),
    "an expert without a temperature": ("temperature", lambda: expert(temperature=None)),
    "an expert's discount above 1": ("discount", lambda: expert(discount=2)),
    # The learner.
    "a problem that is a game": ("problem", lambda: GSIIRL(game())),  # pyright: ignore[reportArgumentType]
    "an unknown lower level": ("lower_level", lambda: GSIIRL(problem(), lower_level="guess")),  # pyright: ignore[reportArgumentType]
    "an unknown way to explore": ("explore", lambda: GSIIRL(problem(), explore="thomson")),  # pyright: ignore[reportArgumentType]
    "an empty way to explore": ("explore", lambda: GSIIRL(problem(), explore="")),  # pyright: ignore[reportArgumentType]
    "an unknown policy to hand back": ("hand_back", lambda: GSIIRL(problem(), hand_back="best")),  # pyright: ignore[reportArgumentType]
    "an unknown feedback": ("feedback", lambda: GSIIRL(problem(), feedback="all")),  # pyright: ignore[reportArgumentType]
    "draws of a posterior that is not there": (
        "lower_level",
        lambda: GSIIRL(problem(), lower_level="matching", explore="thompson"),
    ),
    "no iteration": ("iterations", lambda: fit(None, 0)),
    "half an iteration": ("iterations", lambda: fit(None, 0.5)),
    "no trajectory": ("trajectories", lambda: fit(None, 3, 0)),
    "trajectories of text": ("trajectories", lambda: fit(None, 3, "20")),
    "a seed below 0": ("seed", lambda: fit(None, 3, 20, -1)),
    "a seed that does not fit": ("seed", lambda: fit(None, 3, 20, 2**31)),
    "a seed that is no number": ("seed", lambda: fit(None, 3, 20, None)),
    "no seed": ("seeds", lambda: fit(None, 3, 20, seeds=0)),
    "an expert that demonstrates nothing": ("expert", lambda: fit(Mute())),
    "an expert that is a reward": ("expert", lambda: fit(SMALL.expert)),
    "an expert that must be told a reward": ("expert", lambda: fit(SIMULATED)),
    "an expert of a longer game": ("expert", lambda: fit(expert(game=game(horizon=4)))),
    "an expert that may do what the problem forbids": ("expert", lambda: fit(expert(game=game(expert_actions=None)))),
    "an expert whose game ends elsewhere": ("expert", lambda: fit(expert(game=game(terminal=None)))),
    # What a user's own expert shows.
    "demonstrations that are a list": ("demonstrations", lambda: check([1, 2])),
    "too few demonstrations": ("demonstrations.states", lambda: check(seen(states=np.ones((4, HORIZON), int)))),
    "states that are not whole": ("demonstrations.states", lambda: check(seen(states=np.ones((5, HORIZON))))),
    "a state that is none": ("demonstrations.states", lambda: check(seen(states=np.full((5, HORIZON), 3)))),
    "a state below 0": ("demonstrations.states", lambda: check(seen(states=np.full((5, HORIZON), -1)))),
    "an action that is none": ("demonstrations.actions.expert", lambda: check(seen(expert=np.full((5, HORIZON), 3)))),
    "an action that is forbidden": (
        "demonstrations.actions.learner",
        lambda: check(seen(learner=np.ones((5, HORIZON), int))),
    ),
    "a mask of demonstrations that is no mask": ("demonstrations.mask", lambda: check(seen(mask=np.ones(5, bool)))),
    # The result.
    "a state that does not exist": ("state", lambda: made_result().act(3, 0, 0)),
    "a state that is below 0": ("state", lambda: made_result().act(-1, 0, 0)),
    "a state that is no number": ("state", lambda: made_result().act("start", 0, 0)),  # pyright: ignore[reportArgumentType]
    "a state that is a list": ("state", lambda: made_result().act([1], 0, 0)),  # pyright: ignore[reportArgumentType]
    "a state that is True": ("state", lambda: made_result().act(True, 0, 0)),
    "a step after the last": ("t", lambda: made_result().act(0, HORIZON, 0)),
    "half a step": ("t", lambda: made_result().act(0, 0.5, 0)),  # pyright: ignore[reportArgumentType]
    "a key of text": ("key", lambda: made_result().act(0, 0, "key")),
    "a true reward of another shape": ("expert_reward", lambda: made_result().evaluate(SMALL.own)),
    "no true reward": ("expert_reward", lambda: made_result().evaluate(None)),
    "a true reward that is NaN": ("expert_reward", lambda: made_result().evaluate(np.full(JOINT, np.nan))),
    "no temperature to evaluate at": (
        "temperature",
        lambda: made_result(problem(temperature=None)).evaluate(SMALL.expert),
    ),
    "a true temperature of 0": ("temperature", lambda: made_result().evaluate(SMALL.expert, 0)),
    "an anchor that is no weight": ("name", lambda: made_result().expert_reward.anchored("toll", 1.0)),
    "an anchor of the other sign": (
        "value",
        lambda: made_result().expert_reward.anchored("state 0, learner 0, expert 1", -1.0),
    ),
    "an anchor of 0": ("value", lambda: made_result().expert_reward.anchored("state 0, learner 0, expert 1", 0.0)),
    "an anchor whose weight is 0": (
        "value",
        lambda: made_result().expert_reward.anchored("state 0, learner 0, expert 0", 1.0),
    ),
    "an anchor of text": ("value", lambda: made_result().expert_reward.anchored("state 0, learner 0, expert 1", "1")),  # pyright: ignore[reportArgumentType]
}


def refusal(argument: str, call: Callable[[], object]) -> None:
    """See that `call` is refused in one line about `argument`, and that nothing is compiled for that."""
    with counted_compilations() as compiled, pytest.raises(InputError) as caught:
        call()
    said = str(caught.value)
    assert said.startswith(f"{argument}: ")
    assert "\n" not in said
    assert caught.value.problem
    assert caught.value.mend
    assert not compiled


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_is_refused(case: str) -> None:
    refusal(*WRONG[case])


FOLDERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "a folder that is not there": ("folder", lambda path: load(path / "absent")),
    "a file for a folder": ("folder", lambda path: load(path / "file")),
    "a folder that holds no result": ("folder", lambda path: load(path)),
    "another seed than is saved": ("seed", lambda path: (made_result().save(path / "new"), load(path / "new", 7))),
    "saving where files are": ("folder", lambda path: made_result().save(path)),
    "saving where a file is": ("folder", lambda path: made_result().save(path / "file")),
    "saving below a file": ("folder", lambda path: made_result().save(path / "file" / "below")),
}


@pytest.mark.parametrize("case", FOLDERS)
def test_a_folder_that_cannot_be_is_refused(case: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a result")
    argument, call = FOLDERS[case]
    refusal(argument, lambda: call(tmp_path))


@pytest.mark.parametrize("name", ["result.json", "result.safetensors", "history.parquet"])
def test_a_damaged_file_of_a_result_is_named(name: str, tmp_path: Path) -> None:
    made_result().save(tmp_path / "new")
    path = tmp_path / "new" / name
    path.write_bytes(path.read_bytes()[:-20])
    refusal(str(path), lambda: load(tmp_path / "new"))


def test_a_result_that_lacks_an_array_is_refused(tmp_path: Path) -> None:
    made_result().save(tmp_path / "new")
    path = tmp_path / "new" / "result.json"
    path.write_text(path.read_text().replace('"seed"', '"sede"'))
    refusal(str(path), lambda: load(tmp_path / "new"))


def test_what_is_left_out_is_zero() -> None:
    left_out = Problem(game(), temperature=0.3)
    np.testing.assert_array_equal(left_out.own_reward.dense(), np.zeros(JOINT))
    np.testing.assert_array_equal(left_out.dependent_value.dense(), np.zeros(JOINT))
    assert left_out.discount == 0.95


def test_an_own_reward_holds_whatever_the_expert_does() -> None:
    table = np.asarray(problem().own_reward.dense())
    np.testing.assert_array_equal(table, np.broadcast_to(SMALL.own[:, :, None], JOINT))
    joint = np.asarray(problem(own_reward=SMALL.dependent).own_reward.dense())
    np.testing.assert_array_equal(joint, SMALL.dependent)


def test_features_may_be_a_mapping_or_an_array_with_names() -> None:
    mapped = problem(expert_features={"toll": ONES, "detour": SMALL.dependent})
    table = np.stack([ONES, SMALL.dependent], -1)
    named = problem(expert_features=table, expert_names=["toll", "detour"])
    unnamed = problem(expert_features=table)
    assert list(mapped.expert_names) == list(named.expert_names) == ["toll", "detour"]
    assert list(unnamed.expert_names) == ["feature 0", "feature 1"]
    for each in (mapped, named, unnamed):
        np.testing.assert_array_equal(each.expert_features.payoff(jnp.array([2.0, 1.0])).dense(), 2 + SMALL.dependent)


def test_features_that_the_library_made_serve_too() -> None:
    table = np.stack([ONES, SMALL.dependent], -1)
    assert list(problem(expert_features=TabularFeatures(table=table)).expert_names) == ["feature 0", "feature 1"]
    assert list(problem(expert_features=TabularFeatures(table=table, names=("a", "b"))).expert_names) == ["a", "b"]
    assert problem(expert_features=IndicatorFeatures(shape=JOINT)).expert_names == problem().expert_names


def test_without_features_every_state_and_joint_action_has_a_weight_of_its_own() -> None:
    names = problem().expert_names
    assert len(names) == np.prod(JOINT)
    assert names[0] == "state 0, learner 0, expert 0"
    assert names[-1] == "state 2, learner 1, expert 2"
    # In the order of the table's entries.
    assert names[int(np.ravel_multi_index((1, 0, 2), JOINT))] == "state 1, learner 0, expert 2"


def test_lists_tuples_and_single_precision_are_read_as_numbers() -> None:
    listed = problem(
        own_reward=SMALL.own.tolist(),
        dependent_value=jnp.asarray(SMALL.dependent, jnp.float32),
        temperature=np.float32(0.5),
        discount=1,
    )
    np.testing.assert_array_equal(listed.own_reward.dense(), problem().own_reward.dense())
    assert np.asarray(listed.dependent_value.dense()).dtype == np.float64
    assert (listed.temperature, listed.discount) == (0.5, 1.0)


def test_numbers_of_numpy_and_jax_are_numbers_too() -> None:
    assert problem(temperature=jnp.asarray(0.5)).temperature == 0.5
    result = made_result()
    assert result.act(np.int64(0), np.int32(1), 3) == result.act(0, 1, 3)  # pyright: ignore[reportArgumentType]


def test_a_problem_and_a_result_say_what_they_are_in_one_line() -> None:
    assert repr(problem()) == "Problem(3 states, 2 x 3 actions, 3 steps, 18 weights)"
    assert repr(GSIIRL(problem())) == f"GSIIRL({problem()!r})"
    assert "seed 0, 1 iterations of 20" in repr(made_result())
