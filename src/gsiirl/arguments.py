"""Numbers and arrays that a user gives, checked."""

import inspect

import numpy as np
from jaxtyping import Array

from gsiirl.errors import InputError


def signature_of(kind: type) -> inspect.Signature:
    """The arguments of a class by its `__init__`, where its `__new__` takes those of another one too."""
    _, *parameters = inspect.signature(kind.__init__).parameters.values()
    return inspect.Signature(parameters)


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


def numbers(argument: str, values: object) -> np.ndarray:
    """`values` as an array of finite numbers in double precision.

    Raises:
        InputError: `values` are no numbers, or one is NaN or infinite.
    """
    array = array_of(argument, values)
    if array.dtype.kind not in "biuf":
        raise InputError(argument, f"holds {array.dtype}, no real numbers", "give an array of numbers")
    array = array.astype(np.float64)
    if not np.isfinite(array).all():
        place = np.argwhere(~np.isfinite(array))[0].tolist()
        raise InputError(argument, f"is {array[tuple(place)]} at {place}", "give finite numbers")
    return array


def array_of(argument: str, values: object) -> np.ndarray:
    """`values` as an array.

    Raises:
        InputError: lists in it differ in length.
    """
    try:
        return np.asarray(values)
    except ValueError as error:
        raise InputError(argument, f"is no array ({error})", "give nested lists of one length, or an array") from error


def seed_of(value: object, number: int = 1) -> int:
    """`value` as the first of `number` seeds of random numbers, which are from 0 to 2³¹ − 1.

    Raises:
        InputError: it is none.
    """
    seed = whole_number("seed", value, 0)
    if seed + number > 2**31:
        raise InputError("seed", f"cannot be {value!r}", "give a whole number below 2147483648")
    return seed


def whole_number(argument: str, value: object, least: int) -> int:
    """`value` as an integer of at least `least`.

    Raises:
        InputError: it is none.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise InputError(argument, f"cannot be {value!r}", f"give a whole number of at least {least}")
    return int(value)
