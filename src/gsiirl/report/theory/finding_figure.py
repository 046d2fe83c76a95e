"""The figure of a finding: its panels side by side."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gsiirl.report.figures.style import FAINT_COLOUR, Look
from gsiirl.report.theory.looks import curve_looks, role_of
from gsiirl.report.theory.ticks import label_linear_axis, label_log_axis
from gsiirl.report.words.numbers import format_number
from gsiirl.runs.findings import Curve, Finding, Panel

BAND_ALPHA = 0.16
WIDTH, PLOT_HEIGHT, LINE_HEIGHT = 9.6, 3.1, 0.19
CHARACTER_WIDTH = 0.078
"""Inches, of the legend's letters."""
MANY_POINTS = 30
"""A curve of more points has no markers."""
BEND = 0.05
"""A curve that leaves its fitted line by more, as a share of its height, has no slope."""
Y_LABEL_LETTERS = 36
TINY = float(np.finfo(float).tiny)


def draw_finding(finding: Finding) -> Figure | None:
    """One pair of axes for each panel, the names of its curves below it; None without panels."""
    panels = finding.panels
    if not panels:
        return None
    # A single panel has its legend beside it: with one below, the page would be half empty.
    single, columns = len(panels) == 1, max(2, min(len(panels), 3))
    rows = -(-len(panels) // columns)
    letters = int(WIDTH / columns / CHARACTER_WIDTH) - 9
    labels = [[textwrap.fill(_label(panel, curve), letters) for curve in panel.curves] for panel in panels]
    lines = 0 if single else max(sum(label.count("\n") + 1 for label in each) for each in labels)
    titles = max(len(textwrap.wrap(panel.title, letters)) for panel in panels)
    height = PLOT_HEIGHT + LINE_HEIGHT * (lines + titles) + 0.5
    figure = Figure(figsize=(WIDTH, rows * height), layout="constrained")
    ratios = (1.7, 1) if single else None
    axes = list(figure.subplots(rows, columns, squeeze=False, width_ratios=ratios).ravel())
    looks = curve_looks(panels)
    for axis, panel, names in zip(axes, panels, labels, strict=False):
        _draw_panel(axis, panel, names, looks)
        axis.set_title(textwrap.fill(panel.title, 2 * letters if single else letters))
        at = {"loc": "center left"} if single else {"loc": "upper left", "bbox_to_anchor": (0.0, -0.18)}
        beside = axes[1] if single else axis
        handles = axis.get_legend_handles_labels()
        beside.legend(*handles, fontsize=9, borderaxespad=0.0, handlelength=2.6, **at)
    for empty in axes[len(panels) :]:
        empty.set_axis_off()
    return figure


def undrawn_points(finding: Finding) -> int:
    """Number of points that the figure cannot show: not finite, or not positive on a logarithmic axis."""
    curves = [(panel, curve) for panel in finding.panels for curve in panel.curves]
    return sum(int(np.sum(~_drawable(panel, np.array(curve.x), np.array(curve.y)))) for panel, curve in curves)


def straight_slope(panel: Panel, curve: Curve) -> float | None:
    """Slope of a curve of at least three points on logarithmic axes; None where it is far from a straight line."""
    if not (panel.log_x and panel.log_y) or curve.role == "guide":
        return None
    x, y = np.array(curve.x), np.array(curve.y)
    kept = _drawable(panel, x, y)
    if np.unique(x[kept]).size < 3:
        return None
    x, y = np.log(x[kept]), np.log(y[kept])
    slope, start = np.polyfit(x, y, 1)
    far = np.std(y - slope * x - start) > BEND * max(np.ptp(y), 1.0)
    return None if far else float(slope)


def _label(panel: Panel, curve: Curve) -> str:
    slope = straight_slope(panel, curve)
    return curve.name if slope is None else f"{curve.name} (slope {format_number(slope, 2)})"


def drawn_points(panel: Panel, curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Places, heights and both ends of the band around them, [points]; NaN where a point cannot be drawn."""
    x, y = np.array(curve.x, dtype=float), np.array(curve.y, dtype=float)
    y = np.where(_drawable(panel, x, y), y, np.nan)
    spread = np.array(curve.spread) if curve.spread else np.zeros_like(y)
    # A logarithmic axis has no zero: a band that reaches it ends at the axis.
    low = np.maximum(y - spread, TINY) if panel.log_y else y - spread
    return x, y, low, y + spread


def heights(panel: Panel) -> tuple[float, float] | None:
    """Ends of a logarithmic vertical axis; None where no point can be drawn, or the axis is not one."""
    ends = [drawn_points(panel, curve)[1:] for curve in panel.curves]
    edges = np.concatenate([np.ravel(each) for each in ends]) if ends else np.zeros(0)
    edges = edges[np.isfinite(edges) & (edges > TINY)]
    if not panel.log_y or edges.size == 0:
        return None
    bottom, top = np.log(edges.min()), np.log(edges.max())
    margin = max(0.06 * (top - bottom), 0.05)
    return float(np.exp(bottom - margin)), float(np.exp(top + margin))


def _draw_panel(axis: Axes, panel: Panel, names: list[str], looks: dict[tuple[str, str], Look]) -> None:
    for curve, name in zip(panel.curves, names, strict=True):
        _draw_curve(axis, panel, curve, name, looks[role_of(curve), curve.name])
    axis.set_xlabel(panel.x_label)
    axis.set_ylabel(textwrap.fill(panel.y_label, Y_LABEL_LETTERS))
    points = sorted({x for curve in panel.curves for x in curve.x})
    if panel.log_x and any(x > 0 for x in points):
        axis.set_xscale("log")
        label_log_axis(axis.xaxis, [x for x in points if x > 0 and np.isfinite(x)], at_points=True)
    else:
        label_linear_axis(axis.xaxis, whole=all(float(x).is_integer() for x in points))
    if not any(np.isfinite(drawn_points(panel, curve)[1]).any() for curve in panel.curves):
        axis.text(0.5, 0.5, "no point can be drawn", transform=axis.transAxes, ha="center", color=FAINT_COLOUR)
    elif limits := heights(panel):
        axis.set_yscale("log")
        axis.set_ylim(*limits)
        label_log_axis(axis.yaxis, list(axis.get_ylim()), at_points=False)
    else:
        label_linear_axis(axis.yaxis)


def _draw_curve(axis: Axes, panel: Panel, curve: Curve, name: str, look: Look) -> None:
    x, y, low, high = drawn_points(panel, curve)
    markers: Look = {"marker": ""} if len(x) > MANY_POINTS else {}
    axis.plot(x, y, label=name, **(look | markers))
    if curve.spread:
        axis.fill_between(x, low, high, color=look["color"], alpha=BAND_ALPHA, linewidth=0)


def _drawable(panel: Panel, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Which points can be drawn, [points]."""
    kept = np.isfinite(x) & np.isfinite(y)
    if panel.log_x:
        kept &= x > 0
    if panel.log_y:
        kept &= y > 0
    return kept
