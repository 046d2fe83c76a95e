"""Numbers as text."""

import pytest

from gsiirl.report.words.numbers import format_difference, format_number, format_signed, unbroken


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


@pytest.mark.parametrize(
    ("value", "text"), [(1.5, "+1.50"), (-1.5, "\N{MINUS SIGN}1.50"), (-0.0, "0.00"), (1e-9, "0.000")]
)
def test_a_sign_stands_before_what_is_not_zero(value: float, text: str) -> None:
    assert format_signed(value) == text


@pytest.mark.parametrize(
    ("value", "interval", "text"),
    [
        (1.7, (1.45, 1.95), "+1.70 (1.45 to 1.95)"),
        (0.0001, (0.00005, 0.00015), "+0.000100 (0.000050 to 0.000150)"),
        (-0.0021, (-0.0023, -0.0019), "\N{MINUS SIGN}0.00210 (\N{MINUS SIGN}0.00230 to \N{MINUS SIGN}0.00190)"),
        (2e-15, (2e-15, 2e-15), "0.00 (0.00 to 0.00)"),
        (0.0, (0.0, 0.0), "0.00 (0.00 to 0.00)"),
        (1.7, None, "+1.70"),
    ],
)
def test_a_difference_has_the_digits_that_its_interval_needs(
    value: float, interval: tuple[float, float] | None, text: str
) -> None:
    assert format_difference(value, interval) == text


def test_numbers_stay_beside_their_units() -> None:
    assert unbroken("98.0 % of 1.0 ± 0.5") == "98.0\N{NO-BREAK SPACE}% of 1.0\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}0.5"
