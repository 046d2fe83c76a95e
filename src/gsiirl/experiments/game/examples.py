"""Small games that a preset comes with, as the arrays that a file of one's own would hold."""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from gsiirl.experiments.game.preset import Preset

MOVES = ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1))
"""Rows and columns: stay, up, down, left, right."""


def maze() -> dict[str, Any]:
    """A maze of 3 x 4 cells, cut in two by a wall with a door in each row: the expert walks, the learner holds a door.

    The learner opens one of three doors a step, the expert stays or goes to a neighbouring cell. Every step on the
    upper right cell is worth 1 and on the lower right one 0.6, and walking costs 0.05. A state is a cell.
    """
    rows, columns, wall = 3, 4, 2
    cells = list(itertools.product(range(rows), range(columns)))
    follows = np.zeros((len(cells), rows, len(MOVES), len(cells)))
    for (state, (row, column)), door, (action, (down, right)) in itertools.product(
        enumerate(cells), range(rows), enumerate(MOVES)
    ):
        goal = (row + down, column + right)
        shut = {column, goal[1]} == {wall - 1, wall} and row != door
        follows[state, door, action, cells.index(goal) if goal in cells and not shut else state] = 1.0
    upper, lower = (np.zeros(follows.shape[:3]) for _ in range(2))
    upper[cells.index((0, columns - 1))], lower[cells.index((rows - 1, columns - 1))] = 1.0, 1.0
    effort = np.broadcast_to(np.arange(len(MOVES)) > 0, follows.shape[:3]).astype(float)
    return {
        "transitions": follows,
        "initial": np.eye(len(cells))[cells.index((1, 0))],
        "horizon": 8,
        "expert_reward": upper + 0.6 * lower - 0.05 * effort,
        "expert_features": np.stack([upper, lower, effort], axis=-1),
        "expert_names": np.array(["upper right cell", "lower right cell", "walking"]),
        "temperature": 0.2,
    }


def soccer() -> dict[str, Any]:
    """Littman's soccer (1994) on a field of 2 x 3 cells, until somebody scores.

    Each side stays or moves to a neighbouring cell; who moves first is decided by a coin. Who would move onto the other
    stays, and leaves it the ball. The learner scores by leaving the field to the right with the ball, the expert to the
    left. A state is both cells and who has the ball; the last one is the end. The expert earns 1 for a goal of its own
    and −1 for the learner's.
    """
    rows, columns = 2, 3
    cells = list(itertools.product(range(rows), range(columns)))
    states = [(cell, other, ball) for cell, other in itertools.permutations(cells, 2) for ball in (0, 1)]
    place, end = {state: index for index, state in enumerate(states)}, len(states)
    follows = np.zeros((end + 1, len(MOVES), len(MOVES), end + 1))
    goals = np.zeros((2, end + 1, len(MOVES), len(MOVES)))
    follows[end, ..., end] = 1.0
    beyond = (columns, -1)
    for state, actions, first in itertools.product(states, itertools.product(range(5), repeat=2), (0, 1)):
        at, ball, scored = [state[0], state[1]], state[2], None
        for side in (first, 1 - first):
            down, right = MOVES[actions[side]]
            goal = (at[side][0] + down, at[side][1] + right)
            if goal == at[1 - side]:
                ball = 1 - side
            elif goal in cells:
                at[side] = goal
            elif ball == side and goal[1] == beyond[side]:
                scored = side
                break
        if scored is not None:
            goals[(scored, place[state], *actions)] += 0.5
        follows[(place[state], *actions, end if scored is not None else place[at[0], at[1], ball])] += 0.5
    initial = np.zeros(end + 1)
    for ball in (0, 1):
        initial[place[((0, 0), (1, columns - 1), ball)]] = 0.5
    return {
        "transitions": follows,
        "initial": initial,
        "horizon": 8,
        "terminal": np.arange(end + 1) == end,
        "expert_reward": goals[1] - goals[0],
        "expert_features": np.moveaxis(goals[::-1], 0, -1),
        "expert_names": np.array(["own goal", "other's goal"]),
        "temperature": 0.1,
    }


def walk() -> dict[str, Any]:
    """Somebody alone on a field of 3 x 3 cells, who slips on every tenth step: a Markov decision process.

    A step on the lower right cell is worth 1, on the middle one −0.5, and walking costs 0.05.
    """
    cells = list(itertools.product(range(3), range(3)))
    follows = np.zeros((len(cells), len(MOVES), len(cells)))
    for (state, (row, column)), (action, (down, right)) in itertools.product(enumerate(cells), enumerate(MOVES)):
        goal = (row + down, column + right)
        follows[state, action, cells.index(goal) if goal in cells else state] += 0.9
        follows[state, action, state] += 0.1
    features = np.zeros((len(cells), len(MOVES), 3))
    features[8, :, 0] = features[4, :, 1] = features[:, 1:, 2] = 1.0
    return {
        "transitions": follows,
        "initial": np.eye(len(cells))[0],
        "horizon": 8,
        "expert_reward": features @ [1.0, -0.5, -0.05],
        "expert_features": features,
        "expert_names": np.array(["lower right cell", "middle cell", "walking"]),
        "temperature": 0.2,
    }


EXAMPLES: dict[Preset, Callable[[], dict[str, Any]]] = {"cooperative": maze, "competitive": soccer, "classic": walk}
"""The game of each preset, where no other is named."""
