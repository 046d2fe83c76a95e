"""The panels of a figure as charts of Altair: values under the pointer, runs and seeds switched on and off."""

from typing import TYPE_CHECKING

import polars

from gsiirl.report.curves.learning_curves import CurvePanel, Level, far_in_words
from gsiirl.report.curves.specification import ROW, nearest_mark, specification
from gsiirl.report.figures.charts import Chart, Charts, Key
from gsiirl.report.output.chart_program import charts_installed
from gsiirl.report.read.group import GameGroup
from gsiirl.report.words.algorithms import algorithm_style

if TYPE_CHECKING:
    import altair

MOST_ROWS = 2000
"""Of the table of a panel; of longer runs every second iteration is shown, or every third, and so on."""
DASHES = {"--": ("dashed", [6, 4]), "-.": ("dashed", [6, 3, 2, 3]), ":": ("dotted", [2, 3])}
"""By matplotlib's line: that of CSS, and that of Vega."""
SHOWN = "indexof(runs, datum.run) >= 0 && indexof(seeds, datum.seed) >= 0"


def charts_of(group: GameGroup, panels: list[CurvePanel], levels: list[Level]) -> Charts | None:
    """The panels as charts; None where there is none, or the extra `interactive` is not installed."""
    if not panels or not charts_installed():
        return None
    tables = [panel_table(group, panel.metric) for panel in panels]
    seeds = sorted({seed for table in tables for seed in table["seed"]})
    runs = [
        Key(label, algorithm_style(run.algorithm).colour) for label, run in group.learners.items() if run.kept_seeds
    ]
    charts = [
        Chart(
            panel.title,
            _meaning(panel),
            specification(
                [*_curves(panel, table, runs), *_levels(panel)], runs=[run.label for run in runs], seeds=seeds
            ),
        )
        for panel, table in zip(panels, tables, strict=True)
    ]
    return Charts(charts, runs, [Key(each.label, each.colour, DASHES[each.line][0]) for each in levels], seeds)


def panel_table(group: GameGroup, metric: str) -> polars.DataFrame:
    """A metric of every run that learns: `run`, `seed`, `iteration` and `value`, of at most about `MOST_ROWS` rows."""
    tables = [
        run.seed_curves(metric).select(
            polars.lit(label).alias("run"), "seed", "iteration", value=polars.col("value").cast(float).round_sig_figs(6)
        )
        for label, run in group.learners.items()
    ]
    table = polars.concat(tables, how="vertical_relaxed")
    step = -(-len(table) // MOST_ROWS)
    number = polars.col("iteration").rank("dense").over("run")
    return table.filter(((number - 1) % max(step, 1) == 0) | (number == number.max().over("run")))


def _meaning(panel: CurvePanel) -> str:
    if panel.far is None or panel.limits is None:
        return panel.meaning
    far = far_in_words(panel.far, below=panel.far.value < panel.limits[0])
    return f"{panel.meaning} ({far})" if panel.meaning else far


def _curves(panel: CurvePanel, table: polars.DataFrame, runs: list[Key]) -> "list[altair.Chart]":
    """Bands, single seeds, means, and the mean that the pointer is nearest to."""
    import altair as alt

    kinds = {"run": "string", "seed": "number", "iteration": "number", "value": "number"}
    rows = alt.InlineData(table.write_csv(), format=alt.CsvDataFormat(type="csv", parse=kinds))
    iterations = sorted(table["iteration"])
    # Of what is shown alone the ends would be lost as the last run is switched off.
    ends = alt.Scale(domain=[iterations[0], iterations[-1]], nice=False) if iterations else alt.Undefined
    iteration = alt.X("iteration:Q", title="iteration", scale=ends, axis=alt.Axis(tickMinStep=1, grid=False))
    limits = alt.Scale(domain=list(panel.limits), zero=False) if panel.limits else alt.Scale(zero=False)
    axis = alt.Axis(format=".0%") if panel.shares else alt.Axis()
    height, low = (alt.Y(f"{name}:Q", title=None, scale=limits, axis=axis) for name in ("value", "low"))
    scale = alt.Scale(domain=[run.label for run in runs], range=[run.colour for run in runs])
    colour = alt.Color("run:N", scale=scale, legend=None)
    shown = alt.Chart(rows).transform_filter(SHOWN)
    means = (
        shown.transform_aggregate(
            value="mean(value)", deviation="stdev(value)", count="count()", groupby=["run", "iteration"]
        )
        .transform_calculate(deviation="datum.count > 1 ? datum.deviation : 0")
        .transform_calculate(low="datum.value - datum.deviation", high="datum.value + datum.deviation")
    )
    return [
        means.mark_area(opacity=0.16, clip=True).encode(iteration, low, alt.Y2("high:Q"), colour),
        shown.mark_line(opacity=0.45, strokeWidth=0.8, clip=True).encode(iteration, height, colour, detail="seed:N"),
        means.mark_line(strokeWidth=2.2, clip=True).encode(iteration, height, colour),
        nearest_mark(means, _told(panel.shares), iteration, height, colour),
    ]


def _told(shares: bool) -> str:
    """What the pointer is told, as an expression of Vega."""
    mean, deviation = (".1%", ".1%") if shares else (".4~g", ".2~g")
    # Vega-Lite's own list of fields leaves words out where the nearest mark is asked.
    told = f"format({ROW}.value, '{mean}') + ({ROW}.count > 1 ? ' ± ' + format({ROW}.deviation, '{deviation}') : '')"
    return f"{{'title': {ROW}.run, 'iteration': {ROW}.iteration, 'mean': {told}, 'seeds': {ROW}.count}}"


def _levels(panel: CurvePanel) -> "list[altair.Chart]":
    import altair as alt

    return [
        alt.Chart(alt.InlineData([{"value": level.value}]))
        .mark_rule(color=level.colour, strokeWidth=1.6, strokeDash=DASHES[level.line][1])
        .encode(y="value:Q")
        for level in panel.levels
    ]
