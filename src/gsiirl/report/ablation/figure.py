"""The figure of an ablation: the return of each variant against MARL's."""

import numpy as np
import polars
from matplotlib.figure import Figure

from gsiirl.report.ablation.results import AblationResults
from gsiirl.report.curves.point_charts import SHAPES, PointAxis, PointCurve, PointPanel, point_charts
from gsiirl.report.figures.charts import Charts
from gsiirl.report.figures.style import FAINT_COLOUR, TEXT_COLOUR, Look
from gsiirl.report.read.estimate import Estimate
from gsiirl.report.words.numbers import format_number

COLOURS = ("#2563eb", "#d97706", "#0d9488", "#be185d", "#475569", "#65a30d", "#7c2d12")
MARKERS = "osD^vPX"
HEIGHT = "deployed return less MARL's"


def draw_ablation(results: AblationResults) -> Figure:
    """Deployed return less MARL's, from the paper's preset to the default; one line for each graph."""
    figure = Figure(figsize=(9.6, 4.4), layout="constrained")
    axes = figure.subplots()
    for index, graph in enumerate(results.plan.graphs):
        means = _means(results, graph)
        spread = np.array([[each.mean - each.low, each.high - each.mean] for each in means]).T
        look: Look = {"color": COLOURS[index % len(COLOURS)], "marker": MARKERS[index % len(MARKERS)]}
        look |= {"markersize": 5, "linewidth": 1.2, "label": graph.replace("-", " ")}
        axes.errorbar(_places(results, index), [each.mean for each in means], yerr=spread, **look)
    axes.set_xticks(range(len(results.plan.variants)), _variants(results))
    axes.set_ylabel(HEIGHT)
    axes.grid(axis="x", visible=False)
    axes.axhline(0.0, color=TEXT_COLOUR, linewidth=1.2, linestyle="--", zorder=1)
    offset = {"xycoords": ("axes fraction", "data"), "xytext": (0, 5), "textcoords": "offset points"}
    look = {"horizontalalignment": "right", "color": FAINT_COLOUR, "fontsize": 9}
    axes.annotate("MARL, given both true rewards", (0.995, 0.0), **offset, **look)
    axes.legend(loc="lower right", ncols=3)
    return figure


def ablation_charts(results: AblationResults) -> Charts | None:
    """The same as a chart; None where the extra `interactive` is not installed."""
    variants = _variants(results)
    curves = []
    for index, graph in enumerate(results.plan.graphs):
        means = _means(results, graph)
        table = polars.DataFrame(
            {
                "x": _places(results, index),
                "y": [each.mean for each in means],
                "low": [each.low for each in means],
                "high": [each.high for each in means],
                "at": variants,
                "told": [f"{format_number(e.mean)} ({format_number(e.low)} to {format_number(e.high)})" for e in means],
            }
        )
        shape = SHAPES[index % len(SHAPES)]
        curves.append(PointCurve(graph.replace("-", " "), table, COLOURS[index % len(COLOURS)], shape=shape))
    panel = PointPanel(
        "Deployed return less MARL's",
        "dashed: MARL, given both true rewards",
        PointAxis("", limits=(-0.4, len(variants) - 0.6), ticks=tuple(enumerate(variants)), slanted=True),
        PointAxis(HEIGHT),
        curves,
        bars=True,
        level=0.0,
    )
    return point_charts([panel])


def _variants(results: AblationResults) -> list[str]:
    first, *changes = results.plan.variants
    return [first.name, *(f"+ {each.name}" for each in changes)]


def _means(results: AblationResults, graph: str) -> list[Estimate]:
    cells = [results.results[graph, variant.name] for variant in results.plan.variants]
    return [Estimate.over(cell.deployed - cell.marl) for cell in cells]


def _places(results: AblationResults, index: int) -> np.ndarray:
    """Where the points of a graph stand, [variants]: beside those of the others, so that no interval hides another."""
    return np.arange(len(results.plan.variants)) + 0.07 * (index - (len(results.plan.graphs) - 1) / 2)
