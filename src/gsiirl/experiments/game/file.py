"""Reading one's own game: from an .npz file of arrays, or from a function in a Python file."""

import runpy
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.arguments import positive
from gsiirl.errors import InputError
from gsiirl.experiments.game.examples import EXAMPLES
from gsiirl.experiments.game.preset import Preset, with_idle_learner, with_roles
from gsiirl.experts.tabular_expert import RespondingExpert
from gsiirl.front_door.saved_problem import problem_arrays, problem_from, problem_settings
from gsiirl.games.tabular import TabularGame
from gsiirl.problems.problem import Problem, joint_payoff
from gsiirl.program.presence import is_file
from gsiirl.runs.files.damage import refuse_damaged, refuse_unreadable

FIELD = "FILE"
REQUIRED = ("initial", "horizon", "expert_reward", "temperature")
OPTIONAL = (
    "transitions", "successors", "probabilities", "own_reward", "dependent_value", "discount", "learner_actions",
    "expert_actions", "terminal", "expert_features", "dependent_features", "expert_names", "dependent_names",
    "reward_scale",
)  # fmt: skip


@dataclass(frozen=True)
class OwnGame:
    """A problem with the truth that a run simulates the expert with."""

    name: str
    problem: Problem
    expert_reward: np.ndarray
    """The true r_e, (S, A_l, A_e)."""
    temperature: float
    """The expert's."""

    def to_json_dict(self) -> dict[str, Any]:
        """What `game.json` holds: the whole game, so that a run goes on without the file it came from."""
        return {
            "name": self.name,
            "problem": {name: array.tolist() for name, array in problem_arrays(self.problem).items()},
            "settings": problem_settings(self.problem),
            "truth": {"expert_reward": self.expert_reward.tolist(), "temperature": self.temperature},
        }

    @classmethod
    def from_json_dict(cls, content: Mapping[str, Any], path: Path) -> "OwnGame":
        """The game in the content of a `game.json`; `path` is for errors.

        Raises:
            InputError: it is damaged.
        """
        with refuse_damaged(path):
            arrays = {name: np.asarray(values) for name, values in content["problem"].items()}
            problem = problem_from(content["settings"], arrays)
            truth = content["truth"]
            return cls(
                str(content["name"]), problem, np.asarray(truth["expert_reward"], float), float(truth["temperature"])
            )


def read_game(name: str, told_temperature: bool, preset: Preset | None = None) -> OwnGame:
    """The game of FILE.npz or FILE.py:NAME; the learner may not be told the temperature.

    With `preset` the learner's rewards are those of a special case, and without a name the game is the preset's own.

    Raises:
        InputError: there is no such file or function, or what it holds is no game, or none of the preset's.
    """
    if preset is None:
        return _read(name, told_temperature, lambda arrays: arrays)
    adapted = with_idle_learner if preset == "classic" else dict[str, Any]
    if name:
        own = _read(name, told_temperature, adapted)
    else:
        example = EXAMPLES[preset]
        own = _of_arrays(adapted(example()), example.__name__, example.__name__, told_temperature)
    return replace(own, problem=with_roles(own.problem, own.expert_reward, preset, own.name))


def _read(name: str, told_temperature: bool, adapted: Callable[[dict[str, Any]], dict[str, Any]]) -> OwnGame:
    path_name, _, function = name.partition(":") if ".py:" in name else (name, "", "")
    path = Path(path_name)
    with refuse_unreadable(FIELD, path, "give FILE.npz, or FILE.py:NAME"):
        if not is_file(path):
            raise InputError(FIELD, f"{path_name} is no file", "give FILE.npz, or FILE.py:NAME")
    if function:
        return _from_function(path, function, told_temperature)
    if path.suffix != ".npz":
        raise InputError(FIELD, f"{path_name} is neither .npz nor .py:NAME", "give FILE.npz, or FILE.py:NAME")
    return _of_arrays(adapted(_load(path)), str(path), path.stem, told_temperature)


def _load(path: Path) -> dict[str, Any]:
    """The arrays of a file, those of a game and no others."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays: dict[str, Any] = {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, KeyError) as error:
        raise InputError(FIELD, f"{path} is no .npz of plain arrays ({error})", "write it with numpy.savez") from error
    unknown = sorted(set(arrays) - {*REQUIRED, *OPTIONAL})
    missing = [name for name in REQUIRED if name not in arrays]
    if unknown:
        raise InputError(f"{unknown[0]} in {path}", "is no array of a game", f"use {', '.join(REQUIRED + OPTIONAL)}")
    if missing:
        raise InputError(f"{', '.join(missing)} in {path}", "is missing", "add it with numpy.savez")
    return arrays


def _of_arrays(arrays: dict[str, Any], path: str, name: str, told_temperature: bool) -> OwnGame:
    """The game of these arrays; `path` is where they are from, for errors."""
    if ("transitions" in arrays) == ("successors" in arrays and "probabilities" in arrays):
        raise InputError(
            f"transitions in {path}", "is missing, or given twice", "give it, or successors and probabilities"
        )
    given = [each for each in ("horizon", "temperature", "discount") if each in arrays]
    numbers = {each: _number(np.asarray(arrays.pop(each)), f"{each} in {path}") for each in given}
    transitions = arrays.get("transitions")
    pair = (arrays.get("successors"), arrays.get("probabilities"))
    horizon = numbers["horizon"]
    if not horizon.is_integer():
        raise InputError(f"horizon in {path}", f"cannot be {horizon}", "give a whole number of at least 1")
    game = TabularGame.from_arrays(
        pair if transitions is None else transitions,
        initial=arrays["initial"],
        horizon=int(horizon),
        learner_actions=arrays.get("learner_actions"),
        expert_actions=arrays.get("expert_actions"),
        terminal=arrays.get("terminal"),
    )
    temperature = positive(f"temperature in {path}", numbers["temperature"])
    names = {
        each: None if each not in arrays else [str(name) for name in np.atleast_1d(arrays[each])]
        for each in ("expert_names", "dependent_names")
    }
    scale = arrays.get("reward_scale")
    problem = Problem(
        game,
        own_reward=arrays.get("own_reward"),
        dependent_value=arrays.get("dependent_value"),
        discount=numbers.get("discount", 0.95),
        temperature=temperature if told_temperature else None,
        expert_features=arrays.get("expert_features"),
        dependent_features=arrays.get("dependent_features"),
        expert_names=names["expert_names"],
        dependent_names=names["dependent_names"],
        reward_scale=None if scale is None else _number(scale, f"reward_scale in {path}"),
    )
    reward = joint_payoff("expert_reward", arrays["expert_reward"], game).dense()
    return OwnGame(name, problem, np.asarray(reward), temperature)


def _from_function(path: Path, name: str, told_temperature: bool) -> OwnGame:
    mend = "let it return (Problem, true reward), or (Problem, RespondingExpert)"
    try:
        found = runpy.run_path(str(path)).get(name)
    except Exception as error:
        raise InputError(FIELD, f"{path} cannot be run ({error!r})", "mend the file") from error
    if not callable(found):
        problem = f"{name} in {path} is no function" if found is not None else f"{path} has no function {name}"
        raise InputError(FIELD, problem, "name one that is there")
    try:
        returned = found()
    except InputError:
        raise
    except Exception as error:
        raise InputError(FIELD, f"{name} of {path} failed ({error!r})", "mend the function") from error
    if not isinstance(returned, tuple) or len(returned) != 2 or not isinstance(returned[0], Problem):
        raise InputError(FIELD, f"{name} of {path} returned {type(returned).__name__}", mend)
    problem, truth = returned
    if not isinstance(problem.game, TabularGame):
        raise InputError(FIELD, f"{name} of {path} returned a game that is none of arrays", "use TabularGame")
    if isinstance(truth, RespondingExpert):
        reward, temperature = truth.reward, float(truth.temperature)
    elif hasattr(truth, "demonstrate"):
        raise InputError(FIELD, f"{name} of {path} returned an expert that is no RespondingExpert", "use it in Python")
    else:
        reward, temperature = joint_payoff("true reward", truth, problem.game), problem.temperature
    if temperature is None:
        raise InputError(FIELD, f"{name} of {path} says nowhere the expert's temperature", "return a RespondingExpert")
    if not told_temperature:
        problem = problem_from(problem_settings(problem) | {"temperature": None}, problem_arrays(problem))
    return OwnGame(f"{path.stem}:{name}", problem, np.asarray(reward.dense()), temperature)


def _number(value: np.ndarray, field: str) -> float:
    array = np.asarray(value)
    if array.ndim != 0 or array.dtype.kind not in "iuf":
        raise InputError(field, f"is {array.dtype} of shape {array.shape}", "give one number")
    return float(array)
