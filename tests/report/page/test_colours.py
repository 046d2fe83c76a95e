"""Text can be read on its ground, by day and in the dark: WCAG 2 asks for a contrast of 4.5, of what is no text 3."""

import re
from pathlib import Path

import pytest

import gsiirl.report

STYLE = (Path(gsiirl.report.__file__).parent / "templates" / "page.css").read_text()
DAY, DARK = (
    dict(re.findall(r"--(\w+): (#[0-9a-f]+);", block)) for block in re.findall(r":root \{(.*?)\}", STYLE, re.DOTALL)
)
TEXTS = {
    "page": ("text", "soft", "faint", "accent"),
    "card": ("text", "soft", "faint", "failed"),
    "cell": ("text", "faint", "failed"),
    "told": ("text",),
    "warned": ("text",),
    "good": ("held",),
    "bad": ("missed",),
}
"""By ground, the colours of what is written on it."""


def luminance(colour: str) -> float:
    shares = [int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5)]
    linear = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return sum(weight * share for weight, share in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_the_contrast_is_that_of_the_formula() -> None:
    assert contrast("#ffffff", "#000000") == pytest.approx(21)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)


def test_the_dark_changes_every_colour() -> None:
    assert DAY.keys() == DARK.keys()
    assert {name for name in DAY if DAY[name] == DARK[name]} == set()


@pytest.mark.parametrize("colours", [DAY, DARK], ids=["day", "dark"])
def test_text_stands_out_from_its_ground(colours: dict[str, str]) -> None:
    pairs = {(text, ground): contrast(colours[text], colours[ground]) for ground in TEXTS for text in TEXTS[ground]}
    assert {pair: value for pair, value in pairs.items() if value < 4.5} == {}
    for ground in ("page", "card"):
        assert contrast(colours["accent"], colours[ground]) >= 3


def test_every_colour_has_a_name() -> None:
    rules = re.sub(r":root \{.*?\}", "", STYLE, flags=re.DOTALL)
    assert set(re.findall(r"#[0-9a-f]{3,8}\b", rules)) <= {"#fff"}


def test_the_drawings_white_becomes_the_cards_grey_in_the_dark() -> None:
    share = float(re.findall(r"invert\(([0-9.]+)\)", STYLE)[0])
    assert round(255 * (1 - share)) == int(DARK["card"][1:3], 16)
