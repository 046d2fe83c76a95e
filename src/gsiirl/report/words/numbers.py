"""Numbers as text."""


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
