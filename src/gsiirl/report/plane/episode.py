"""One recorded trajectory of bodies in the plane."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import polars

from gsiirl.report.read.run import ReportedRun


@dataclass(frozen=True)
class PlaneEpisode:
    """A trajectory and its place among the recorded ones."""

    seed: int
    trajectory: int
    recorded: int
    """Number of trajectories it was picked from."""
    positions: dict[str, np.ndarray]
    """Of each body at the steps 0, ..., T, [T + 1, 2]."""
    start: dict[str, float]
    """Every recorded column at step 0."""

    @property
    def steps(self) -> int:
        """Number of steps, T."""
        return len(next(iter(self.positions.values()))) - 1

    def choice(self, trajectories: str, measure: str) -> str:
        """A sentence that says why this one is shown; `measure` is such as `whose smallest distance`."""
        return (
            f"Of {self.recorded} recorded {trajectories} this is the one {measure} is the median: neither the best nor "
            "the worst."
        )


def pick_episode(
    run: ReportedRun, bodies: Sequence[str], score: Callable[[PlaneEpisode], float]
) -> PlaneEpisode | None:
    """The recorded episode whose score is the median; of two in the middle the lower, of equals the first; or None.

    Raises:
        InputError: the table of the paths lacks a column.
    """
    tables = run.trajectories([f"{body}_{axis}" for body in bodies for axis in "xy"])
    ranked = sorted((_episode(table, bodies, len(tables)) for table in tables), key=score)
    return ranked[(len(ranked) - 1) // 2] if ranked else None


def _episode(table: polars.DataFrame, bodies: Sequence[str], recorded: int) -> PlaneEpisode:
    return PlaneEpisode(
        seed=int(table["seed"][0]),
        trajectory=int(table["trajectory"][0]),
        recorded=recorded,
        positions={body: table.select(f"{body}_x", f"{body}_y").to_numpy() for body in bodies},
        start={name: float(value) for name, value in table.row(0, named=True).items()},
    )


def distances(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Distance at every step, [T + 1], of a body to another or to a place."""
    return np.linalg.norm(first - second, axis=-1)
