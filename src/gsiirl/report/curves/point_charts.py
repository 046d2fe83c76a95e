"""Curves through measured points as charts of Altair: values under the pointer, curves switched on and off."""

import json
import math
import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import polars

from gsiirl.report.curves.specification import ROW, nearest_mark, specification
from gsiirl.report.figures.charts import Chart, Charts, Key
from gsiirl.report.output.chart_program import charts_installed

if TYPE_CHECKING:
    import altair

Line = Literal["solid", "dashed", "dotted"]
LABEL_LETTERS = 34
SHAPES = ("circle", "square", "diamond", "triangle-up", "triangle-down", "cross")


@dataclass(frozen=True)
class PointCurve:
    """A curve and how it looks."""

    name: str
    points: polars.DataFrame
    """`x`, `y`, the ends `low` and `high` of what is around `y`; in words `at`, the place, and `told`, the value."""
    colour: str
    line: Line = "solid"
    shape: str = "circle"
    """One of `SHAPES`; empty for a curve whose points are not marked."""


@dataclass(frozen=True)
class PointAxis:
    """An axis, with its ends and its ticks where they are not left to the chart."""

    label: str
    logarithmic: bool = False
    limits: tuple[float, float] | None = None
    ticks: tuple[tuple[float, str], ...] = ()
    """Places and what stands there."""
    slanted: bool = False


@dataclass(frozen=True)
class PointPanel:
    """One pair of axes with its curves."""

    title: str
    meaning: str
    x: PointAxis
    y: PointAxis
    curves: list[PointCurve]
    bars: bool = False
    """Whether `low` and `high` are the ends of a bar at each point; else they bound a band."""
    level: float | None = None
    """Height of a dashed line across."""


DASHES = {"solid": [1, 0], "dashed": [6, 3], "dotted": [2, 3]}


def point_charts(panels: list[PointPanel]) -> Charts | None:
    """The panels as charts; None where one has no point, or the extra `interactive` is not installed."""
    drawn = [any(len(curve.points) for curve in panel.curves) for panel in panels]
    if not drawn or not all(drawn) or not charts_installed():
        return None
    keys = {curve.name: Key(curve.name, curve.colour, curve.line) for panel in panels for curve in panel.curves}
    return Charts([Chart(each.title, each.meaning, _specified(each)) for each in panels], list(keys.values()))


def _specified(panel: PointPanel) -> str:
    import altair as alt

    curves = panel.curves
    names = [curve.name for curve in curves]
    rows = polars.concat([curve.points.select(polars.lit(curve.name).alias("run"), polars.all()) for curve in curves])
    kinds = {name: "string" if name in ("run", "at", "told") else "number" for name in rows.columns}
    data = alt.InlineData(rows.write_csv(), format=alt.CsvDataFormat(type="csv", parse=kinds))
    shown = alt.Chart(data).transform_filter("indexof(runs, datum.run) >= 0")
    label, axis = textwrap.wrap(panel.y.label, LABEL_LETTERS), _axis(panel.y)
    # Of points alone the ends of an axis would change, or be lost, as curves are switched off.
    scale = _scale(panel.y, [*rows["y"], *rows["low"], *rows["high"], *([] if panel.level is None else [panel.level])])
    place = alt.X("x:Q", title=panel.x.label or None, scale=_scale(panel.x, list(rows["x"])), axis=_axis(panel.x))
    height, low = (alt.Y(f"{name}:Q", title=label, scale=scale, axis=axis) for name in ("y", "low"))
    colour = alt.Color("run:N", scale=alt.Scale(domain=names, range=[each.colour for each in curves]), legend=None)
    dashes = alt.Scale(domain=names, range=[DASHES[each.line] for each in curves])
    shapes = alt.Scale(domain=names, range=[each.shape or SHAPES[0] for each in curves])
    around = shown.mark_rule(strokeWidth=1.2, clip=True) if panel.bars else shown.mark_area(opacity=0.16, clip=True)
    lines = shown.mark_line(strokeWidth=1.8, clip=True)
    points = shown.mark_point(size=28, filled=True, opacity=1, clip=True)
    told = f"{{'title': {ROW}.run, 'at': {ROW}.at, 'value': {ROW}.told}}"
    layers = [
        around.encode(place, low, alt.Y2("high:Q"), colour),
        lines.encode(place, height, colour, alt.StrokeDash("run:N", scale=dashes, legend=None)),
        points.transform_filter(alt.FieldOneOfPredicate("run", [curve.name for curve in curves if curve.shape])).encode(
            place, height, colour, alt.Shape("run:N", scale=shapes, legend=None)
        ),
        nearest_mark(shown, told, place, height, colour),
    ]
    if panel.level is not None:
        level = alt.Chart(alt.InlineData([{"y": panel.level}])).mark_rule(strokeWidth=1.2, strokeDash=[6, 4])
        layers.insert(0, level.encode(alt.Y("y:Q", title=label, scale=scale, axis=axis)))
    return specification(layers, runs=names)


def _scale(axis: PointAxis, values: list[float]) -> "altair.Scale":
    import altair as alt

    kind = alt.Undefined if not axis.logarithmic else "log"
    if axis.limits:
        return alt.Scale(type=kind, domain=list(axis.limits), nice=False)
    finite = [each for each in values if math.isfinite(each)]
    return alt.Scale(type=kind, domain=[min(finite), max(finite)], nice=False, padding=10)


def _axis(axis: PointAxis) -> "altair.Axis":
    import altair as alt

    if not axis.ticks:
        return alt.Axis(tickCount=6, labelOverlap=True, format="~r")
    places = [place for place, _ in axis.ticks]
    words = f"{json.dumps([words for _, words in axis.ticks])}[indexof({json.dumps(places)}, datum.value)]"
    angle, limit = (-35, 160) if axis.slanted else (alt.Undefined, alt.Undefined)
    return alt.Axis(
        values=places,
        labelExpr=words,
        labelOverlap=True,
        labelAngle=angle,
        labelLimit=limit,
        grid=not axis.slanted,
    )
