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
            return cls(
                robot_goal=_array(game, "robot_goal", (2,)),
                human_goal=_array(game, "human_goal", (2,)),
                robot_start=_array(game, "robot_start", (2, 2)),
                human_start=_array(game, "human_start", (2, 2)),
                arena=_array(game, "arena", (2, 2)),
                goal_radius=float(game["goal_radius"]),
                safe_distance=float(game["safe_distance"]),
                collision_distance=float(game["collision_distance"]),
            )
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                str(run / "game.json"), f"is damaged ({error!r})", "start the run again in another folder"
            ) from error


def _array(game: dict[str, Any], name: str, shape: tuple[int, ...]) -> np.ndarray:
    array = np.array(game[name], dtype=float)
    if array.shape != shape:
        raise ValueError(f"{name} has shape {array.shape}, not {shape}")
    return array
