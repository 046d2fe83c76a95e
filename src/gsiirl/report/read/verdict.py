"""The rule by which one learner is called better than another: nowhere else is it decided."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import stdtrit

RULE = (
    "Better or worse is said where the 95 % interval of the difference (Student's t) does not hold 0, with at least 2 "
    "seeds on both sides: seed by seed where both ran the same seeds, else by Welch's test. Numbers that are equal but "
    "for rounding are the same; of everything else the page says that it cannot tell. Failed seeds count."
)
"""As it stands on the page."""

ROUNDING, SMALLEST = 1e-6, 1e-9
"""Differences up to this share of the numbers, or of this size, are rounding."""


@dataclass(frozen=True)
class SeedValues:
    """A number for each seed, or one exact number that holds for every seed."""

    values: np.ndarray
    """[seeds]; of shape [1] where it is exact."""
    seeds: list[int] | None
    """None where the number is exact, such as a return at the equilibrium of a finite game."""

    @classmethod
    def exactly(cls, value: float) -> "SeedValues":
        """One number that every seed would give."""
        return cls(np.array([value]), None)

    @property
    def lacking(self) -> int:
        """Seeds without a finite number."""
        return int(np.sum(~np.isfinite(self.values)))


@dataclass(frozen=True)
class Verdict:
    """What can be said of the difference between two sides, the first less the second."""

    sign: int
    """1 or -1 where the first is certainly higher or lower; else 0."""
    tie: bool
    """Whether both are the same but for rounding."""
    count: int
    """Seeds of the side with fewer: of the pairs, where both ran the same seeds."""
    lacking: int
    """Seeds without a finite number, of which nothing can be said."""
    difference: float | None
    """Mean; None where a seed lacks a number."""
    interval: tuple[float, float] | None
    """95 %; None of one seed, and where a seed lacks a number."""

    def words(self, higher: str = "better", lower: str = "worse") -> str:
        """The verdict on the first side."""
        if self.tie:
            return "the same"
        if self.sign:
            return higher if self.sign > 0 else lower
        if self.lacking:
            return f"cannot tell: {self.lacking} seed{'s' * (self.lacking > 1)} without a number"
        return f"cannot tell with {self.count} seed{'s' * (self.count != 1)}"

    def json(self) -> dict[str, Any]:
        """The entry in `table.json`."""
        content: dict[str, Any] = {"verdict": self.words(), "seeds": self.count}
        if self.difference is not None:
            content["difference"] = self.difference
        if self.interval is not None:
            content |= dict(zip(("low", "high"), self.interval, strict=True))
        return content


def judge_difference(first: SeedValues, second: SeedValues) -> Verdict:
    """The verdict of the rule on two sides, of which at least one has seeds."""
    count = min(len(each.seeds) for each in (first, second) if each.seeds is not None)
    lacking = first.lacking + second.lacking
    if lacking:
        return Verdict(0, False, count, lacking, None, None)
    numbers = np.concatenate([first.values, second.values])
    rounding = max(SMALLEST, ROUNDING * float(np.abs(numbers).max()))
    differences = _differences(first, second)
    if differences is not None:
        count, mean, half = len(differences), float(differences.mean()), _half_width(differences)
        tie = bool(np.abs(differences).max() <= rounding)
    else:
        mean, half = float(first.values.mean() - second.values.mean()), _welch_half_width(first.values, second.values)
        tie = bool(np.ptp(numbers) <= rounding)
    if count < 2:
        return Verdict(0, tie, count, 0, mean, None)
    certain = not tie and abs(mean) > max(half, rounding)
    return Verdict(int(math.copysign(certain, mean)), tie, count, 0, mean, (mean - half, mean + half))


def _differences(first: SeedValues, second: SeedValues) -> np.ndarray | None:
    """Differences seed by seed, of at least 2 seeds that both ran; None where there are no such."""
    if first.seeds is None or second.seeds is None:
        return first.values - second.values
    common, ours, theirs = np.intersect1d(first.seeds, second.seeds, return_indices=True)
    return first.values[ours] - second.values[theirs] if len(common) > 1 else None


def _half_width(values: np.ndarray) -> float:
    """Of the interval of a mean; 0 of one value."""
    if len(values) < 2:
        return 0.0
    return float(stdtrit(len(values) - 1, 0.975) * values.std(ddof=1) / math.sqrt(len(values)))


def _welch_half_width(first: np.ndarray, second: np.ndarray) -> float:
    """Of the interval of the difference of two means; 0 where one side has one value, or neither varies."""
    sides = (first, second)
    if min(map(len, sides)) < 2:
        return 0.0
    squares = [each.var(ddof=1) / len(each) for each in sides]
    total = sum(squares)
    if not total:
        return 0.0
    freedom = total**2 / sum(square**2 / (len(each) - 1) for square, each in zip(squares, sides, strict=True))
    return float(stdtrit(freedom, 0.975) * math.sqrt(total))
