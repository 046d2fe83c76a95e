"""The crossing in the `game.json` of a run."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.runs.files.damage import refuse_damaged

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
        with refuse_damaged(run / "game.json"):
            arrays = {name: np.array(game[name], dtype=float) for name in ARRAYS}
            for name, shape in ARRAYS.items():
                if arrays[name].shape != shape:
                    raise ValueError(f"{name} has shape {arrays[name].shape}, not {shape}")
            lengths: dict[str, Any] = {name: float(game[name]) for name in LENGTHS}
            return cls(**arrays, **lengths)
