"""Numbers as text."""

import pytest

from gsiirl.report.words.numbers import format_number


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (-16.96, "\N{MINUS SIGN}16.96"),
        (-0.0001, "0.000"),
        (-0.021, "\N{MINUS SIGN}0.021"),
        (0.0, "0.00"),
        (3.0, "3.00"),
    ],
)
def test_numbers_read_well(value: float, text: str) -> None:
    assert format_number(value) == text
