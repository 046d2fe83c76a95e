"""A problem of arrays as it is saved: arrays by name, and settings for JSON."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gsiirl.front_door.learned_reward import dense
from gsiirl.games.tabular import TabularGame
from gsiirl.problems.problem import Problem, StateActionNames
from gsiirl.rewards.linear import TabularFeatures


def problem_settings(problem: Problem) -> dict[str, Any]:
    """The part of a problem that is no array, for JSON."""
    return {
        "horizon": problem.game.horizon,
        "discount": problem.discount,
        "temperature": problem.temperature,
        "reward_scale": problem.reward_scale,
        "expert_names": None if isinstance(problem.expert_names, StateActionNames) else list(problem.expert_names),
        "dependent_names": None
        if isinstance(problem.dependent_names, StateActionNames)
        else list(problem.dependent_names),
    }


def problem_arrays(problem: Problem) -> dict[str, np.ndarray]:
    """The arrays of a problem, by name; `problem_settings` has the rest of it."""
    game = problem.game
    assert isinstance(game, TabularGame), "only games of arrays are saved as arrays"
    arrays = {
        "successors": game.successors,
        "probabilities": game.probabilities,
        "initial": game.initial,
        "learner_actions": game.learner_actions,
        "expert_actions": game.expert_actions,
        "terminal": game.terminal_states,
        "own_reward": dense(problem.own_reward),
        "dependent_value": dense(problem.dependent_value),
    }
    for name, features in (
        ("expert_features", problem.expert_features),
        ("dependent_features", problem.dependent_features),
    ):
        if isinstance(features, TabularFeatures):
            arrays[name] = features.table
    return {name: np.asarray(array) for name, array in arrays.items() if array is not None}


def problem_from(content: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Problem:
    """The problem that `problem_arrays` and `problem_settings` describe."""
    game = TabularGame.from_arrays(
        (arrays["successors"], arrays["probabilities"]),
        initial=arrays["initial"],
        horizon=content["horizon"],
        learner_actions=arrays.get("learner_actions"),
        expert_actions=arrays.get("expert_actions"),
        terminal=arrays.get("terminal"),
    )
    return Problem(
        game,
        own_reward=arrays["own_reward"],
        dependent_value=arrays["dependent_value"],
        discount=content["discount"],
        temperature=content["temperature"],
        expert_features=arrays.get("expert_features"),
        dependent_features=arrays.get("dependent_features"),
        expert_names=content["expert_names"],
        dependent_names=content["dependent_names"],
        reward_scale=content["reward_scale"],
    )
