"""Slopes on logarithmic axes: fitted to what was measured, and drawn beside it."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from gsiirl.runs.findings import Curve


def fitted_slope(x: Sequence[float], y: Sequence[float] | Float[np.ndarray, " k"]) -> float:
    """Of ln y over ln x, by least squares."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def guide(name: str, x: Sequence[float], start: float, exponent: float) -> Curve:
    """The power of x that begins at `start`, from end to end of x."""
    first, last = float(x[0]), float(x[-1])
    return Curve(name, [first, last], [start, start * (last / first) ** exponent], role="guide")
