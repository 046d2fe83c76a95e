"""The crossing of a `game.json`: where robot and human start and want to be."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.errors import InputError


@dataclass(frozen=True)
class Crossing:
    """Places are (x, y); boxes are [[x0, x1], [y0, y1]]."""

    robot_goal: np.ndarray
    human_goal: np.ndarray
    robot_start: np.ndarray
    human_start: np.ndarray
    arena: np.ndarray
    goal_radius: float
    safe_distance: float
    collision_distance: float

    @classmethod
    def read(cls, game: dict[str, Any], run: Path) -> "Crossing":
        """The crossing in `game.json`.

        Raises:
            InputError: the description is damaged; `run` names it.
        """
        try:
            shapes = {"robot_goal": (2,), "human_goal": (2,)}
            shapes |= dict.fromkeys(("robot_start", "human_start", "arena"), (2, 2))
            arrays = {name: np.array(game[name], dtype=float) for name in shapes}
            wrong = [name for name, shape in shapes.items() if arrays[name].shape != shape]
            if wrong:
                raise ValueError(f"{wrong[0]} is no place or box")
            lengths = {name: float(game[name]) for name in ("goal_radius", "safe_distance", "collision_distance")}
            return cls(**arrays, **lengths)
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                str(run / "game.json"), f"is damaged ({error!r})", "start the run again in another folder"
            ) from error
