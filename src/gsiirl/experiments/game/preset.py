"""Special cases of the problem: who earns what in a cooperative, a competitive and a classic game."""

from typing import Any, Literal

import numpy as np

from gsiirl.errors import InputError
from gsiirl.front_door.saved_problem import problem_arrays, problem_from, problem_settings
from gsiirl.problems.problem import Problem

Preset = Literal["cooperative", "competitive", "classic"]
SHARE = {"cooperative": 1.0, "competitive": -1.0, "classic": 0.0}
"""What the learner earns of each unit that the expert earns."""
ALONE = {"transitions": 3, "successors": 3, "probabilities": 3, "expert_reward": 2, "expert_features": 3}
"""Axes of the arrays of a game in which there is no learner."""


def with_idle_learner(arrays: dict[str, Any]) -> dict[str, Any]:
    """The arrays of a Markov decision process, r(s, a) and P[s, a, s'], with a learner that has one action.

    Arrays in which there is a learner are left as they are.
    """
    if np.ndim(arrays["expert_reward"]) != ALONE["expert_reward"]:
        return arrays
    given = {name: np.asarray(arrays[name]) for name in ALONE if name in arrays}
    return arrays | {name: each[:, None] if each.ndim == ALONE[name] else each for name, each in given.items()}


def with_roles(problem: Problem, expert_reward: np.ndarray, preset: Preset, game: str) -> Problem:
    """The problem with r_li = 0, and r_ld = r_e (cooperative), −r_e (competitive) or 0 (classic).

    `expert_reward` is r_e (S, A_l, A_e); what the problem said of the learner's rewards is gone. `game` is its name,
    for errors.

    Raises:
        InputError: in a classic game something depends on what the learner does.
    """
    arrays = problem_arrays(problem)
    if preset == "classic":
        # Of successors only those count that can follow.
        follows = np.where(arrays["probabilities"] > 0, arrays["successors"], 0)
        read = ("transitions", follows), ("transitions", arrays["probabilities"]), ("expert_reward", expert_reward)
        for name, array in read:
            if (array != array[:, :1]).any():
                mend = "give P[s, a, s'] and r(s, a) of the expert alone, or the same for all actions of the learner"
                raise InputError(f"{name} of {game}", "depends on what the learner does", mend)
    rewards = {"own_reward": np.zeros_like(expert_reward), "dependent_value": SHARE[preset] * expert_reward}
    return problem_from(problem_settings(problem), arrays | rewards)
