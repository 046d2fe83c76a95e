"""Animations are small and show every step."""

import base64
import io

import pytest
from matplotlib.figure import Figure
from PIL import Image
from report.synthetic_plane import STEPS

from gsiirl.report import ReportFiles
from gsiirl.report.figures.animation import animate


def dots(frame: int) -> Figure:
    figure = Figure(figsize=(1, 1))
    figure.add_axes((0.5, 0, 0.5, 1), ylim=(0, 3)).plot([0, 1], [0, frame])
    return figure


def test_every_frame_is_shown_white_stays_white_and_the_same_figures_give_the_same_bytes() -> None:
    content = animate(dots, 3)["gif"]
    assert content == animate(dots, 3)["gif"]
    with Image.open(io.BytesIO(content)) as image:
        assert getattr(image, "n_frames", 1) == 3
        assert image.convert("RGB").getpixel((1, 1)) == (255, 255, 255)


@pytest.mark.slow
def test_animations_of_a_page_are_small_and_show_every_step(drawn_plane_report: ReportFiles) -> None:
    page = drawn_plane_report.page.read_text()
    animations = [path for path in drawn_plane_report.figures if path.suffix == ".gif"]
    assert [path.stem for path in animations] == ["game-1-animation", "game-2-animation"]
    for path in animations:
        content = path.read_bytes()
        assert len(content) < 400_000
        assert base64.b64encode(content).decode() in page
        with Image.open(io.BytesIO(content)) as image:
            assert getattr(image, "n_frames", 1) == STEPS + 1
            assert image.convert("RGB").getpixel((1, 1)) == (255, 255, 255)
