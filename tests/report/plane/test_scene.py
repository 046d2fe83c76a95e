"""The plane of the two continuous games."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure

from gsiirl.report.figures.style import figure_style
from gsiirl.report.plane.scene import prepare_plane


@pytest.mark.parametrize("half", [0.8, 1.12, 1.3, 2.4, 11.0])
def test_numbers_along_an_axis_do_not_touch(half: float) -> None:
    with figure_style():
        figure = Figure(figsize=(4.8, 5.2))
        axes = figure.add_axes((0.14, 0.2, 0.83, 0.76))
        prepare_plane(axes, np.array([[-half, half], [-half, half]]))
        figure.draw_without_rendering()
        extents = [label.get_window_extent() for label in axes.get_xticklabels()]
    space = 4 * figure.dpi / 72
    assert len(extents) > 3
    assert all(left.x1 + space < right.x0 for left, right in pairwise(extents))
