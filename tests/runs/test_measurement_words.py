"""Measurements and their bounds in words."""

import math

import numpy as np
import pytest

from gsiirl.runs import Measurement
from gsiirl.runs.measurement_words import number_in_words, value_in_words


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (0.0, "0"),
        (12.0, "12"),
        (123456.0, "123456"),
        (-1234.56, "-1235"),
        (99999.6, "100000"),
        (-0.03142, "-0.03142"),
        (0.9999999, "1"),
        (9.9999999e-7, "10⁻⁶"),
        (-1.2e-9, "-1.2 x 10⁻⁹"),
        (3.5e12, "3.5 x 10¹²"),
        (1000.0, "1000"),
        (math.inf, "infinite"),
        (math.nan, "not a number"),
    ],
)
def test_numbers_are_written_for_people(number: float, words: str):
    typed = words.replace("-", "\N{MINUS SIGN}").replace("x", "\N{MULTIPLICATION SIGN}")
    assert number_in_words(number) == typed


def test_a_value_is_told_from_its_bound():
    assert value_in_words(Measurement("ratio", 1 + 1e-9, at_most=1.0)) == "1.000000001"
    assert value_in_words(Measurement("ratio", 1.0, at_most=1.0, unit="s")) == "1 s"
    assert value_in_words(Measurement("ratio", float(np.nextafter(1, 2)), at_most=1.0)) != "1"
