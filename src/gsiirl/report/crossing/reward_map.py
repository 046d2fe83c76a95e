"""The human's reward by position, learned and true."""

from dataclasses import dataclass

import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs.files.damage import START_AGAIN


@dataclass(frozen=True)
class RewardMap:
    """Rewards on a grid [Y, X], scaled so that 0 is the lowest and 1 the highest of the grid.

    Demonstrations tell a reward only up to its scale and a constant; scaled, learned and true can be compared.
    """

    x: np.ndarray
    y: np.ndarray
    learned: np.ndarray
    """Mean over seeds."""
    true: np.ndarray
    peaks: np.ndarray
    """Where each seed's learned reward is highest, [seeds, 2]."""

    @classmethod
    def of(cls, run: ReportedRun) -> "RewardMap | None":
        """The map of the kept seeds, or None where the run holds none.

        Raises:
            InputError: the table lacks a column, or is no grid.
        """
        if run.reward_map is None:
            return None
        try:
            kept = run.reward_map.filter(polars.col("seed").is_in(run.kept_seeds)).sort("seed", "y", "x")
            if kept.is_empty():
                return None
            x, y = (kept[name].unique().sort().to_numpy() for name in ("x", "y"))
            shape = (kept["seed"].n_unique(), len(y), len(x))
            learned, true = (kept[name].to_numpy().reshape(shape) for name in ("learned", "true"))
        except (polars.exceptions.PolarsError, ValueError) as error:
            raise InputError(str(run.path / "reward_map.parquet"), f"is damaged ({error})", START_AGAIN) from error
        rows, columns = np.unravel_index(learned.reshape(len(learned), -1).argmax(axis=1), shape[1:])
        peaks = np.stack([x[columns], y[rows]], axis=1)
        return cls(x, y, _scaled(learned).mean(axis=0), _scaled(true).mean(axis=0), peaks)

    @property
    def peak(self) -> np.ndarray:
        """Where the mean learned reward is highest, [2]."""
        row, column = np.unravel_index(self.learned.argmax(), self.learned.shape)
        return np.array([self.x[column], self.y[row]])


def _scaled(rewards: np.ndarray) -> np.ndarray:
    """Each seed's rewards [seeds, Y, X] on 0 to 1; one that is the same everywhere becomes 0."""
    low, high = (extreme(rewards, axis=(1, 2), keepdims=True) for extreme in (np.min, np.max))
    return (rewards - low) / np.where(high > low, high - low, 1.0)
