"""The figure of a finding as charts, whose points tell their values."""

import math

import polars

from gsiirl.report.curves.point_charts import SHAPES, Line, PointAxis, PointCurve, PointPanel, point_charts
from gsiirl.report.figures.charts import Charts
from gsiirl.report.figures.style import Look
from gsiirl.report.theory.finding_figure import MANY_POINTS, drawn_points, heights, straight_slope
from gsiirl.report.theory.looks import LOOKS, curve_looks, role_of
from gsiirl.report.theory.ticks import log_ticks
from gsiirl.report.words.numbers import format_number
from gsiirl.runs.findings import Curve, Finding, Panel
from gsiirl.runs.measurement_words import number_in_words

LINES: dict[str, Line] = {"ours": "solid", "paper": "dashed", "guide": "dotted"}


def finding_charts(finding: Finding) -> Charts | None:
    """The panels that the drawing has; None where none has a point, or the extra `interactive` is not installed."""
    looks = curve_looks(finding.panels)
    return point_charts([_panel(panel, looks) for panel in finding.panels])


def _panel(panel: Panel, looks: dict[tuple[str, str], Look]) -> PointPanel:
    slopes = {curve.name: straight_slope(panel, curve) for curve in panel.curves}
    told = [f"{name} {format_number(slope, 2)}" for name, slope in slopes.items() if slope is not None]
    limits = heights(panel)
    places = sorted({x for curve in panel.curves for x in curve.x if 0 < x < math.inf}) if panel.log_x else []
    return PointPanel(
        panel.title,
        f"slope of {'; '.join(told)}" if told else "",
        PointAxis(panel.x_label, bool(places), ticks=log_ticks(places, at_points=True) if places else ()),
        PointAxis(panel.y_label, panel.log_y, limits, log_ticks(list(limits), at_points=False) if limits else ()),
        [_curve(panel, curve, looks[role_of(curve), curve.name]) for curve in panel.curves],
    )


def _curve(panel: Panel, curve: Curve, look: Look) -> PointCurve:
    table = polars.DataFrame(dict(zip(("x", "y", "low", "high"), drawn_points(panel, curve), strict=True)))
    spread = curve.spread or [0.0] * len(curve.y)
    around = [f" ± {number_in_words(each, 2)}" if each else "" for each in spread]
    table = table.with_columns(
        at=polars.Series([number_in_words(x) for x in curve.x], dtype=polars.String),
        told=polars.Series(
            [number_in_words(y) + more for y, more in zip(curve.y, around, strict=True)], dtype=polars.String
        ),
    ).filter(polars.col("y").is_finite() & polars.col("x").is_finite())
    role = role_of(curve)
    return PointCurve(
        curve.name,
        table,
        look["color"],
        LINES[role],
        "" if role == "guide" or len(table) > MANY_POINTS else SHAPES[LOOKS[role].index(look) % len(SHAPES)],
    )
