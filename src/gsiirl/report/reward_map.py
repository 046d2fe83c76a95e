"""The human's reward by position, as learned and as it is."""

from dataclasses import dataclass

import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.report.run import ReportedRun


@dataclass(frozen=True)
class RewardMap:
    """Rewards on a grid [Y, X], scaled so that 0 is the lowest and 1 the highest of the grid.

    The data tell a reward up to its scale and a constant: scaled, the learned and the true one can be compared.
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
        """The map of the seeds that did not fail, or None where the run holds none.

        Raises:
            InputError: the table lacks a column, or is no grid of finite rewards.
        """
        if run.reward_map is None:
            return None
        try:
            kept = run.reward_map.filter(polars.col("seed").is_in(run.kept_seeds)).sort("seed", "y", "x")
            tables = kept.partition_by("seed", maintain_order=True)
            if not tables:
                return None
            x, y = (np.unique(tables[0][name].to_numpy()) for name in ("x", "y"))
            shape = (len(tables), len(y), len(x))
            learned, true = (kept[name].to_numpy().reshape(shape) for name in ("learned", "true"))
            if not np.isfinite([learned, true]).all():
                raise ValueError("a reward is not finite")
        except (polars.exceptions.PolarsError, ValueError) as error:
            raise InputError(
                str(run.path / "reward_map.parquet"), f"is damaged ({error})", "start the run again in another folder"
            ) from error
        rows, columns = np.unravel_index(learned.reshape(len(tables), -1).argmax(axis=1), shape[1:])
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
