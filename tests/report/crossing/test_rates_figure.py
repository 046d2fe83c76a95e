"""Rates over iterations are drawn with MARL's."""

from pathlib import Path

import numpy as np
import pytest
from report.synthetic import group_of

from gsiirl.report.crossing.rates_figure import draw_rates
from gsiirl.report.figures.style import figure_style


def test_rates_are_drawn_with_marls_level(plane_runs: dict[str, list[Path]]) -> None:
    with figure_style():
        figure = draw_rates(group_of(plane_runs["crossing"]))
    assert figure is not None
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "They collide",
        "The robot reaches its goal",
        "The human reaches its goal",
    ]
    for axes, level in zip(figure.axes, (0.01, 0.97, 0.99), strict=True):
        heights = [np.ravel(line.get_ydata()) for line in axes.lines]
        assert any(height[0] == height[-1] == pytest.approx(level) for height in heights if len(height) == 2)
