"""Numbers that a user gives, checked."""

import numpy as np
from jaxtyping import Array

from gsiirl.errors import InputError


def positive(argument: str, value: object) -> float:
    """`value` as a finite number above 0.

    Raises:
        InputError: it is none.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | np.number | np.ndarray | Array):
        raise InputError(argument, f"cannot be {value!r}", "give a number above 0")
    number = np.asarray(value)
    if number.ndim != 0 or number.dtype.kind not in "iuf" or not np.isfinite(number) or number <= 0:
        raise InputError(argument, f"cannot be {value!r}", "give a finite number above 0")
    return float(number)


def discount_of(value: object) -> float:
    """γ in (0, 1].

    Raises:
        InputError: it is not.
    """
    number = positive("discount", value)
    if number > 1.0:
        raise InputError("discount", f"cannot be {value!r}", "give a number above 0 and at most 1")
    return number
