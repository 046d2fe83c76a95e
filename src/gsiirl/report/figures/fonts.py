"""Which characters a figure can show: those of matplotlib's own font, and of East Asian fonts where there are some."""

from functools import cache

from matplotlib import font_manager

OWN = "DejaVu Sans"
EAST_ASIAN = (
    "Noto Sans CJK JP",
    "Noto Sans CJK SC",
    "Noto Sans CJK TC",
    "Noto Sans CJK KR",
    "Source Han Sans",
    "WenQuanYi Zen Hei",
    "WenQuanYi Micro Hei",
    "Droid Sans Fallback",
    "IPAexGothic",
    "IPAGothic",
    "Hiragino Sans",
    "PingFang SC",
    "Apple SD Gothic Neo",
    "Arial Unicode MS",
    "Microsoft YaHei",
    "Yu Gothic",
    "Malgun Gothic",
)
"""Families that systems come with; the first that has a character draws it."""


@cache
def font_families() -> list[str]:
    """Families for all text, in the order in which a character is looked for."""
    present = {font.name for font in font_manager.fontManager.ttflist}
    return [OWN, *(name for name in EAST_ASIAN if name in present)]


def is_drawable(text: str) -> bool:
    """Whether every character has a glyph in one of the families."""
    return text.isprintable() and all(ord(each) in _characters() for each in text)


@cache
def _characters() -> frozenset[int]:
    fonts = (font_manager.get_font(font_manager.findfont(family)) for family in font_families())
    return frozenset(code for font in fonts for code in font.get_charmap())
