"""The crossing in the `game.json` of a run."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.runs.files.damage import START_AGAIN, refuse_damaged
from gsiirl.runs.files.json_file import as_typed

ARRAYS = {"robot_goal": (2,), "human_goal": (2,), "robot_start": (2, 2), "human_start": (2, 2), "arena": (2, 2)}
"""Shapes by name."""
LENGTHS = ("goal_radius", "safe_distance", "collision_distance")


@dataclass(frozen=True)
class RecordedCrossing:
    """Goals as (x, y); the boxes of the starts and the arena as [[x0, x1], [y0, y1]]."""

    robot_goal: np.ndarray
    human_goal: np.ndarray
    robot_start: np.ndarray
    human_start: np.ndarray
    arena: np.ndarray
    goal_radius: float
    safe_distance: float
    collision_distance: float

    @classmethod
    def read(cls, game: dict[str, Any], run: Path) -> "RecordedCrossing":
        """The crossing in `game`, the content of the `game.json` of the folder `run`.

        Raises:
            InputError: the description is damaged.
        """
        path = run / "game.json"
        described = as_typed(_Described, game, path, START_AGAIN)
        with refuse_damaged(path):
            arrays = {name: np.array(getattr(described, name), dtype=float) for name in ARRAYS}
            for name, shape in ARRAYS.items():
                if arrays[name].shape != shape:
                    raise ValueError(f"{name} has shape {arrays[name].shape}, not {shape}")
            lengths: dict[str, Any] = {name: getattr(described, name) for name in LENGTHS}
            return cls(**arrays, **lengths)


@dataclass(frozen=True)
class _Described:
    """The part of `game.json` that is drawn."""

    robot_goal: list[float]
    human_goal: list[float]
    robot_start: list[list[float]]
    human_start: list[list[float]]
    arena: list[list[float]]
    goal_radius: float
    safe_distance: float
    collision_distance: float
