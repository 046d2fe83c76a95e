"""Which numbers a run folder may hold."""

import numpy as np

LARGEST = 1e100
"""Beyond it squares soon overflow, and a number is as good as infinite."""


def is_sound(values: np.ndarray) -> np.ndarray | np.bool_:
    """Which values are numbers of a size that can be computed with; same shape."""
    # In double precision: single has no number so large.
    return np.abs(np.asarray(values, dtype=float)) <= LARGEST
