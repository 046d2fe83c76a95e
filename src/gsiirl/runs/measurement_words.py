"""A measurement of the theory and its bounds in words."""

import math

from gsiirl.runs.findings import Measurement

DIGITS = 4
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def value_in_words(measurement: Measurement) -> str:
    """The value with its unit, to so many digits that it can be told from its bounds."""
    bounds = [bound for bound in (measurement.at_least, measurement.at_most) if bound is not None]
    digits = DIGITS
    while digits < 17 and any(
        bound != measurement.value and number_in_words(bound, digits) == number_in_words(measurement.value, digits)
        for bound in bounds
    ):
        digits += 1
    return " ".join(filter(None, [number_in_words(measurement.value, digits), measurement.unit]))


def bound_in_words(measurement: Measurement) -> str:
    """`at most 10⁻⁶`; empty where there is none."""
    low, high = measurement.at_least, measurement.at_most
    if low is not None and high is not None:
        return f"{number_in_words(low)} to {number_in_words(high)}"
    if low is not None:
        return f"at least {number_in_words(low)}"
    return "" if high is None else f"at most {number_in_words(high)}"


def number_in_words(number: float, digits: int = DIGITS) -> str:
    """A number of any size, to `digits` significant ones: 12, 0.0314, 1.2 × 10⁻⁹."""
    if math.isnan(number):
        return "not a number"
    if math.isinf(number):
        return "infinite" if number > 0 else "\N{MINUS SIGN}infinite"
    mantissa, exponent = f"{number:.{digits - 1}e}".split("e")
    power = int(exponent)
    if number.is_integer() and power < 6:
        return _trimmed(str(int(number)))
    if -4 < power < 6:
        text = f"{float(f'{mantissa}e{exponent}'):.{max(0, digits - 1 - power)}f}"
        return _trimmed(text)
    mantissa = _trimmed(mantissa)
    sign, digit = ("\N{MINUS SIGN}", mantissa[1:]) if mantissa.startswith("\N{MINUS SIGN}") else ("", mantissa)
    factor = "" if digit == "1" else f"{digit} \N{MULTIPLICATION SIGN} "
    return f"{sign}{factor}{power_of_ten(power)}"


def power_of_ten(power: int) -> str:
    """10⁻⁹; 1 and 10 as they are."""
    return {0: "1", 1: "10"}.get(power) or f"10{str(power).translate(SUPERSCRIPTS)}"


def _trimmed(text: str) -> str:
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return text.replace("-", "\N{MINUS SIGN}")
