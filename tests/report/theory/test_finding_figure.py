"""Figures of findings show their curves, with a look for each role."""

import math
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from report.synthetic_theory import curve, many_panels, missed, power_law

from gsiirl.report.figures.page_figure import figure_files
from gsiirl.report.figures.style import figure_style
from gsiirl.report.theory.finding_figure import draw_finding, straight_slope, undrawn_points
from gsiirl.runs import Finding, Panel


def axes_of(finding: Finding) -> list[Axes]:
    with figure_style():
        figure = draw_finding(finding)
    assert figure is not None
    return [axes for axes in figure.axes if axes.axison]


def legend_of(axes: Axes) -> list[str]:
    legend = axes.get_legend()
    assert legend is not None
    return [text.get_text().replace("\n", " ") for text in legend.get_texts()]


def test_every_curve_is_drawn_and_named():
    finding = power_law()
    panels = axes_of(finding)
    assert len(panels) == len(finding.panels)
    for axes, panel in zip(panels, finding.panels, strict=True):
        assert (axes.get_title(loc="left"), axes.get_xlabel(), axes.get_ylabel()) == (
            panel.title,
            panel.x_label,
            panel.y_label,
        )
        for line, each, name in zip(axes.lines, panel.curves, legend_of(axes), strict=True):
            np.testing.assert_array_equal(line.get_xdata(), each.x)
            np.testing.assert_array_equal(line.get_ydata(), each.y)
            assert name.startswith(each.name)
        assert len(axes.collections) == sum(bool(each.spread) for each in panel.curves)


def test_roles_look_different_and_a_curve_keeps_its_look():
    ours, printed, guide = axes_of(power_law())[0].lines
    assert len({line.get_color() for line in (ours, printed, guide)}) == 3
    assert ours.get_linestyle() == "-"
    assert printed.get_linestyle() != "-"
    assert guide.get_linewidth() < ours.get_linewidth()
    first, second, _ = axes_of(many_panels())
    assert [line.get_color() for line in first.lines] == [line.get_color() for line in second.lines]


def test_slopes_stand_in_the_legend_where_both_axes_are_logarithmic():
    names = legend_of(axes_of(power_law())[0])
    assert names[0].endswith("(slope 2.00)")
    assert names[1].endswith("(slope 0.00)")
    assert names[2] == "slope 2"
    x = np.array([1.0, 2.0, 4.0])
    ours = curve("ours", x, 3 / x)
    logarithmic = Panel("", "", "", [ours])
    assert straight_slope(logarithmic, ours) == pytest.approx(-1)
    assert straight_slope(replace(logarithmic, log_x=False), ours) is None
    assert straight_slope(logarithmic, curve("two points", x[:2], x[:2])) is None
    wide = np.logspace(0, 3, 20)
    assert straight_slope(logarithmic, curve("levels off", wide, 1 / wide + 0.1)) is None


def test_points_that_cannot_be_drawn_are_counted():
    assert undrawn_points(many_panels()) == 6
    assert undrawn_points(power_law()) == 0
    nothing = replace(missed(), panels=[Panel("", "", "", [curve("ours", np.ones(2), np.array([0.0, math.nan]))])])
    (axes,) = axes_of(nothing)
    assert [text.get_text() for text in axes.texts] == ["no point can be drawn"]


def test_a_band_that_reaches_zero_does_not_stretch_a_logarithmic_axis():
    x = np.array([1.0, 10.0, 100.0])
    wide = replace(missed(), panels=[Panel("", "", "", [curve("ours", x, 1 / x, spread=2.0)])])
    (axes,) = axes_of(wide)
    assert axes.get_ylim()[0] > 1e-3


def test_ticks_are_plain_text():
    with figure_style():
        figure = draw_finding(power_law())
        assert figure is not None
        figure_files(figure)
    for axes in figure.axes:
        labels = [label.get_text() for label in (*axes.get_xticklabels(), *axes.get_yticklabels())]
        assert len(labels) >= 4
        assert not any("$" in label for label in labels)
    assert [label.get_text() for label in figure.axes[1].get_xticklabels()] == [
        "8",
        "16",
        "32",
        "64",
        "128",
        "256",
        "512",
    ]


def test_the_same_finding_gives_the_same_bytes():
    def draw() -> dict[str, bytes]:
        with figure_style():
            figure = draw_finding(power_law())
            assert figure is not None
            return figure_files(figure)

    assert draw() == draw()


def test_a_finding_without_panels_has_no_figure():
    assert draw_finding(replace(missed(), panels=[])) is None
