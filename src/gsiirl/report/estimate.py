"""A mean over seeds with its spread and its 95 % interval."""

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

# Student's t, 97.5 % quantile, for 1 to 10 degrees of freedom (any table of it).
T_QUANTILES = (12.7062, 4.3027, 3.1824, 2.7764, 2.5706, 2.4469, 2.3646, 2.3060, 2.2622, 2.2281)
NORMAL_QUANTILE = 1.959963984540054


@dataclass(frozen=True)
class Estimate:
    """Mean and standard deviation (n - 1) over `count` seeds, and the t-interval of the mean."""

    mean: float
    std: float
    low: float
    high: float
    count: int

    @classmethod
    def over(cls, values: np.ndarray) -> "Estimate":
        """Of values of shape [seeds], at least one; one seed has no spread and no interval beyond its value."""
        count, mean = len(values), float(np.mean(values))
        if count == 1:
            return cls(mean, 0.0, mean, mean, count)
        std = float(np.std(values, ddof=1))
        half = t_quantile(count - 1) * std / math.sqrt(count)
        return cls(mean, std, mean - half, mean + half, count)

    def json(self) -> dict[str, Any]:
        """As it stands in `table.json`."""
        return asdict(self)

    def __str__(self) -> str:
        digits = default_digits(self.mean)
        return f"{format_number(self.mean, digits)} ± {format_number(self.std, digits)}"


def t_quantile(freedom: int) -> float:
    """The 97.5 % quantile of Student's t, to four digits."""
    if freedom <= len(T_QUANTILES):
        return T_QUANTILES[freedom - 1]
    # Abramowitz and Stegun 26.7.5.
    z = NORMAL_QUANTILE
    return (
        z
        + (z**3 + z) / (4 * freedom)
        + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
        + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * freedom**3)
    )


def default_digits(value: float) -> int:
    """Decimals that suit a number's size: rewards of scaled networks are small, and two would hide them."""
    return 2 if abs(value) >= 1 or value == 0 else 3


def format_number(value: float, digits: int | None = None) -> str:
    """A number for people: a true minus sign, and no minus before a zero."""
    text = f"{value:.{default_digits(value) if digits is None else digits}f}"
    return text.replace("-", "\N{MINUS SIGN}" if float(text) else "")


def format_share(value: float) -> str:
    """A share for people, in per cent."""
    return f"{format_number(100 * value, 1)} %"
