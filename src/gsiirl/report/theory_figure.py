"""The figure of a finding: its panels side by side, drawn from nothing but their curves."""

import math
import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullLocator

from gsiirl.report.estimate import format_number
from gsiirl.report.figure_style import FAINT_COLOUR
from gsiirl.runs.findings import Curve, Finding, Panel
from gsiirl.runs.measurement_words import number_in_words, power_of_ten

OUR_LOOKS = (("#2563eb", "o"), ("#0d9488", "s"), ("#d97706", "D"), ("#be185d", "^"), ("#475569", "v"), ("#65a30d", "P"))
"""Colour and marker, told apart also without colour."""
PAPER_LOOKS = (
    ("#9333ea", "x"),
    ("#c026d3", "*"),
    ("#6366f1", "+"),
    ("#db2777", "1"),
    ("#7e22ce", "X"),
    ("#a78bfa", "p"),
)
GUIDE_COLOUR, GUIDE_DASHES = "#94a3b8", ("--", ":", "-.")
BAND_ALPHA = 0.16
WIDTH, PLOT_HEIGHT, LINE_HEIGHT = 9.6, 3.1, 0.19
CHARACTER_WIDTH = 0.078
"""Inches, of the legend's letters."""
MANY_POINTS = 30
"""A curve of more points has no markers."""
BEND = 0.05
"""A curve that leaves its straight line by more, as a part of its height, has no slope."""
FEW_TICKS = 8
Y_LABEL_LETTERS = 36


def draw_finding(finding: Finding) -> Figure | None:
    """One pair of axes a panel, the names of its curves below it; None without panels."""
    panels = finding.panels
    if not panels:
        return None
    # A single panel has its legend beside it: below, the page would be half empty.
    columns = max(2, min(len(panels), 3))
    rows = -(-len(panels) // columns)
    looks = _looks(panels)
    letters = int(WIDTH / columns / CHARACTER_WIDTH) - 9
    labels = [[textwrap.fill(_label(panel, curve), letters) for curve in panel.curves] for panel in panels]
    lines = max(sum(label.count("\n") + 1 for label in each) for each in labels) if len(panels) > 1 else 0
    titles = max(len(textwrap.wrap(panel.title, letters)) for panel in panels)
    height = PLOT_HEIGHT + LINE_HEIGHT * (lines + titles) + 0.5
    figure = Figure(figsize=(WIDTH, rows * height), layout="constrained")
    if len(panels) == 1:
        grid = figure.add_gridspec(1, 2, width_ratios=(1.7, 1))
        axes = [figure.add_subplot(grid[0, 0])]
        beside = figure.add_subplot(grid[0, 1])
        beside.set_axis_off()
    else:
        axes = list(figure.subplots(rows, columns, squeeze=False).ravel())
        beside = None
    for axis, panel, names in zip(axes, panels, labels, strict=False):
        _draw_panel(axis, panel, names, looks)
        axis.set_title(textwrap.fill(panel.title, letters if beside is None else 2 * letters))
        handles, texts = axis.get_legend_handles_labels()
        common = {"fontsize": 9, "borderaxespad": 0.0, "handlelength": 2.6}
        if beside is None:
            axis.legend(handles, texts, loc="upper left", bbox_to_anchor=(0.0, -0.18), **common)
        else:
            beside.legend(handles, texts, loc="center left", **common)
    for empty in axes[len(panels) :]:
        empty.set_axis_off()
    return figure


def undrawn_points(finding: Finding) -> int:
    """How many points no figure can show: not finite, or not positive on a logarithmic axis."""
    return sum(
        int(np.sum(~_drawable(panel, np.array(curve.x), np.array(curve.y))))
        for panel in finding.panels
        for curve in panel.curves
    )


def fitted_slope(panel: Panel, curve: Curve) -> float | None:
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


def _looks(panels: list[Panel]) -> dict[tuple[str, str], dict[str, object]]:
    """How each curve is drawn, by role and name: curves of one name look the same in all panels."""
    names: dict[str, list[str]] = {"ours": [], "paper": [], "guide": []}
    for panel in panels:
        for curve in panel.curves:
            of_role = names[curve.role if curve.role in names else "ours"]
            if curve.name not in of_role:
                of_role.append(curve.name)
    looks: dict[tuple[str, str], dict[str, object]] = {}
    for index, name in enumerate(names["ours"]):
        colour, marker = OUR_LOOKS[index % len(OUR_LOOKS)]
        looks["ours", name] = {"color": colour, "marker": marker, "linewidth": 1.8, "markersize": 5, "zorder": 4}
    for index, name in enumerate(names["paper"]):
        colour, marker = PAPER_LOOKS[index % len(PAPER_LOOKS)]
        looks["paper", name] = {
            "color": colour,
            "marker": marker,
            "linewidth": 1.8,
            "linestyle": (0, (4, 2)),
            "markersize": 6,
            "zorder": 3,
        }
    for index, name in enumerate(names["guide"]):
        looks["guide", name] = {
            "color": GUIDE_COLOUR,
            "linewidth": 1.0,
            "linestyle": GUIDE_DASHES[index % len(GUIDE_DASHES)],
            "zorder": 2,
        }
    return looks


def _label(panel: Panel, curve: Curve) -> str:
    slope = fitted_slope(panel, curve)
    return curve.name if slope is None else f"{curve.name} (slope {format_number(slope, 2)})"


def _draw_panel(axis: Axes, panel: Panel, names: list[str], looks: dict[tuple[str, str], dict[str, object]]) -> None:
    edges: list[float] = []
    for curve, name in zip(panel.curves, names, strict=True):
        x, y = np.array(curve.x, dtype=float), np.array(curve.y, dtype=float)
        look = dict(looks[curve.role if curve.role in ("paper", "guide") else "ours", curve.name])
        if len(x) > MANY_POINTS:
            look["marker"] = ""
        drawable = _drawable(panel, x, y)
        y = np.where(drawable, y, np.nan)
        edges += y[drawable].tolist()
        axis.plot(x, y, label=name, **look)  # pyright: ignore[reportArgumentType]
        if curve.spread:
            low, high = y - np.array(curve.spread), y + np.array(curve.spread)
            if panel.log_y:
                # Down to the axis: there is no zero on it.
                low = np.maximum(low, np.finfo(float).tiny)
            axis.fill_between(x, low, high, color=str(look["color"]), alpha=BAND_ALPHA, linewidth=0)
            edges += high[drawable].tolist()
            edges += [value for value in low[drawable].tolist() if value > np.finfo(float).tiny or not panel.log_y]
    axis.set_xlabel(panel.x_label)
    axis.set_ylabel(textwrap.fill(panel.y_label, Y_LABEL_LETTERS))
    points = sorted({x for curve in panel.curves for x in curve.x})
    if panel.log_x and any(x > 0 for x in points):
        axis.set_xscale("log")
        _label_log_axis(axis.xaxis, [x for x in points if x > 0 and np.isfinite(x)], at_points=True)
    else:
        whole = all(float(x).is_integer() for x in points)
        axis.xaxis.set_major_locator(MaxNLocator(nbins=6, integer=whole, min_n_ticks=1))
        axis.xaxis.set_major_formatter(FuncFormatter(_tick))
    if not edges:
        axis.text(0.5, 0.5, "no point can be drawn", transform=axis.transAxes, ha="center", color=FAINT_COLOUR)
        return
    if panel.log_y:
        axis.set_yscale("log")
        bottom, top = np.log(min(edges)), np.log(max(edges))
        margin = max(0.06 * (top - bottom), 0.05)
        axis.set_ylim(float(np.exp(bottom - margin)), float(np.exp(top + margin)))
        _label_log_axis(axis.yaxis, list(axis.get_ylim()), at_points=False)
    else:
        axis.yaxis.set_major_locator(MaxNLocator(nbins=6))
        axis.yaxis.set_major_formatter(FuncFormatter(_tick))


def _label_log_axis(axis: Axis, points: list[float], at_points: bool) -> None:
    """Few ticks, each with a plain number or a power of ten; on a short list of points, at these."""
    axis.set_minor_locator(NullLocator())
    plain = not points or (min(points) >= 1e-3 and max(points) < 1e6)
    axis.set_major_formatter(FuncFormatter(_tick if plain else _power))
    decades = float(np.log10(max(points) / min(points))) if points else 0.0
    if at_points and len(points) <= FEW_TICKS and _far_apart(points, decades):
        axis.set_major_locator(FixedLocator(points))
    elif decades < 0.5:
        axis.set_major_locator(MaxNLocator(nbins=5))
    elif decades < 1.2:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0, 7.0)))
    elif decades < 2.5:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    else:
        axis.set_major_locator(LogLocator(numticks=8))


def _far_apart(points: list[float], decades: float) -> bool:
    """Whether labels at all points have room."""
    gaps = np.diff(np.log10(points))
    return len(points) < 2 or bool(np.all(gaps > 0.11 * decades))


def _tick(value: float, _: object = None) -> str:
    return number_in_words(value)


def _power(value: float, _: object = None) -> str:
    power = math.log10(value)
    return power_of_ten(round(power)) if power == round(power) else number_in_words(value)


def _drawable(panel: Panel, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    kept = np.isfinite(x) & np.isfinite(y)
    if panel.log_x:
        kept &= x > 0
    if panel.log_y:
        kept &= y > 0
    return kept
