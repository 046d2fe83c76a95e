"""Numbers as text."""

import math


def default_digits(value: float) -> int:
    """Number of decimals for a value: 2 from 1 up, else 3, since rewards of scaled networks are small."""
    return 2 if abs(value) >= 1 or value == 0 else 3


def format_number(value: float, digits: int | None = None) -> str:
    """A number with a true minus sign, and with no minus before a zero."""
    text = f"{value:.{default_digits(value) if digits is None else digits}f}"
    return text.replace("-", "\N{MINUS SIGN}" if float(text) else "")


def format_share(value: float) -> str:
    """A share in per cent, with one decimal."""
    return f"{format_number(100 * value, 1)} %"


def format_signed(value: float, digits: int | None = None) -> str:
    """A number with its sign, plus too; none before a zero."""
    text = format_number(value, digits)
    return text if text[0] == "\N{MINUS SIGN}" or not float(text) else f"+{text}"


def format_difference(value: float, interval: tuple[float, float] | None) -> str:
    """A difference with its interval, to so many digits that the interval shows: `+1.70 (1.53 to 1.87)`."""
    width = 0.0 if interval is None else (interval[1] - interval[0]) / 2
    digits = max(2, _digits_that_show(width or abs(value)))
    if interval is None:
        return format_signed(value, digits)
    low, high = (format_number(end, digits) for end in interval)
    return f"{format_signed(value, digits)} ({low} to {high})"


def _digits_that_show(value: float) -> int:
    """Decimals that show two digits of a small number; at most 6, and none of what is smaller."""
    return min(6, 1 - math.floor(math.log10(value))) if value > 1e-6 else 0


def unbroken(text: str) -> str:
    """`text` whose numbers no end of a line parts from their % or their deviation."""
    return text.replace(" %", "\N{NO-BREAK SPACE}%").replace(" ± ", "\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}")
