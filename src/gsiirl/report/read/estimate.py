"""A mean over seeds, with its standard deviation and its 95 % interval."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import stdtrit

from gsiirl.report.words.numbers import default_digits, format_number


@dataclass(frozen=True)
class Estimate:
    """Mean and standard deviation (n - 1) over `count` seeds, and the 95 % t-interval of the mean."""

    mean: float
    std: float
    low: float
    high: float
    count: int
    with_failed: "Estimate | None" = None
    """The same over all seeds, where this one leaves out failed ones; None where none failed, or one has no number."""

    @classmethod
    def over(cls, values: np.ndarray) -> "Estimate":
        """The estimate of values of shape [seeds], at least one; for one seed `std` is 0 and the interval its value."""
        count, mean = len(values), float(np.mean(values))
        if count == 1:
            return cls(mean, 0.0, mean, mean, count)
        std = float(np.std(values, ddof=1))
        half = float(stdtrit(count - 1, 0.975)) * std / math.sqrt(count)
        return cls(mean, std, mean - half, mean + half, count)

    def json(self) -> dict[str, Any]:
        """The entry in `table.json`."""
        content: dict[str, Any] = {name: getattr(self, name) for name in ("mean", "std", "low", "high", "count")}
        return content if self.with_failed is None else content | {"all_seeds": self.with_failed.json()}

    def __str__(self) -> str:
        return self.text(default_digits(self.mean))

    def text(self, digits: int) -> str:
        """Mean and standard deviation; of one seed, which has no spread, its value alone."""
        mean = format_number(self.mean, digits)
        return mean if self.count == 1 else f"{mean} ± {format_number(self.std, digits)}"
