"""Animations are small and show every step."""

import base64
import io

from PIL import Image
from report.synthetic_plane import STEPS

from gsiirl.report import ReportFiles


def test_animations_are_small_and_show_every_step(plane_report: ReportFiles) -> None:
    page = plane_report.page.read_text()
    animations = [path for path in plane_report.figures if path.suffix == ".gif"]
    assert [path.stem for path in animations] == ["game-1-animation", "game-2-animation"]
    for path in animations:
        content = path.read_bytes()
        assert len(content) < 400_000
        assert base64.b64encode(content).decode() in page
        with Image.open(io.BytesIO(content)) as image:
            assert getattr(image, "n_frames", 1) == STEPS + 1
            assert image.convert("RGB").getpixel((1, 1)) == (255, 255, 255)
