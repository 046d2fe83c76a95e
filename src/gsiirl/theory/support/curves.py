"""What checks say in numbers: curves, slopes on logarithmic axes, and the extremes of several games."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Real

from gsiirl.runs.findings import Curve, Measurement

Numbers = Sequence[float] | Real[np.ndarray, " k"]


def fitted_slope(x: Numbers, y: Numbers) -> float:
    """Slope of ln y over ln x, by least squares."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def curve(name: str, x: Numbers, y: Numbers, role: str = "ours") -> Curve:
    """y against x, from numbers of any kind."""
    return Curve(name, [float(each) for each in x], [float(each) for each in y], role=role)


def guide(name: str, x: Numbers, start: float, exponent: float) -> Curve:
    """The power of x that begins at `start`, from end to end of x."""
    ends = np.asarray([x[0], x[-1]], float)
    return curve(name, ends, start * (ends / ends[0]) ** exponent, "guide")


def extremes(name: str, values: Numbers, games: str, at_least: float, at_most: float) -> list[Measurement]:
    """The smallest and the largest of `values`, both within the same bounds; `games` says of what they are."""
    return [
        Measurement(f"{name}, {word} {games}", float(value), at_least=at_least, at_most=at_most)
        for word, value in (("smallest", np.min(values)), ("largest", np.max(values)))
    ]


def median(values: Numbers) -> float:
    """The median, a Python number."""
    return float(np.median(values))
