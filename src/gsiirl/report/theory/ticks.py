"""Ticks with plain numbers, on linear and on logarithmic axes."""

import math
from collections.abc import Callable

import numpy as np
from matplotlib.axis import Axis
from matplotlib.ticker import FixedLocator, FuncFormatter, Locator, LogLocator, MaxNLocator, NullLocator

from gsiirl.runs.measurement_words import number_in_words, power_of_ten

FEW_TICKS = 8


def label_linear_axis(axis: Axis, whole: bool = False) -> None:
    """About six ticks; on whole numbers only where `whole`."""
    axis.set_major_locator(MaxNLocator(nbins=6, integer=whole, min_n_ticks=1 if whole else 2))
    axis.set_major_formatter(FuncFormatter(lambda value, _: number_in_words(value)))


def label_log_axis(axis: Axis, points: list[float], at_points: bool) -> None:
    """Few ticks, each with a plain number or a power of ten; at the points if `at_points` and they are few enough."""
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: _words(points)(value)))
    axis.set_major_locator(_log_locator(points, at_points))


def log_ticks(points: list[float], at_points: bool) -> tuple[tuple[float, str], ...]:
    """The same ticks with their words, from the lowest point to the highest."""
    low, high = min(points), max(points)
    places = _log_locator(points, at_points).tick_values(low, high)
    return tuple((float(each), _words(points)(each)) for each in places if low <= each <= high)


def _log_locator(points: list[float], at_points: bool) -> Locator:
    decades = float(np.log10(max(points) / min(points))) if points else 0.0
    # Labels need room.
    apart = bool(np.all(np.diff(np.log10(points)) > 0.11 * decades))
    if at_points and len(points) <= FEW_TICKS and apart:
        return FixedLocator(points)
    if decades < 0.5:
        return MaxNLocator(nbins=5)
    if decades < 1.2:
        return LogLocator(subs=(1.0, 2.0, 3.0, 5.0, 7.0))
    if decades < 2.5:
        return LogLocator(subs=(1.0, 2.0, 5.0))
    return LogLocator(numticks=8)


def _words(points: list[float]) -> Callable[[float], str]:
    """Plain numbers where all points are of a usual size, else powers of ten."""
    return number_in_words if not points or (min(points) >= 1e-3 and max(points) < 1e6) else _power


def _power(value: float) -> str:
    power = math.log10(value)
    return power_of_ten(round(power)) if power == round(power) else number_in_words(value)
