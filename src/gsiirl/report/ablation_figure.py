"""The figure of an ablation: where each variant ends, against MARL."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gsiirl.report.ablation_results import AblationResults
from gsiirl.report.estimate import Estimate
from gsiirl.report.figure_style import FAINT_COLOUR, TEXT_COLOUR
from gsiirl.runs import Variant

COLOURS = ("#2563eb", "#d97706", "#0d9488", "#be185d", "#475569", "#65a30d", "#7c2d12")
MARKERS = "osD^vPX"
MINUS = "\N{MINUS SIGN}"


def draw_ablation(results: AblationResults) -> Figure:
    """Left the ladder from the paper's preset to the default, right the default less one change each."""
    ladder, without = results.plan.ladder, results.plan.without
    figure = Figure(figsize=(9.6, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(len(ladder), len(without) + 1))
    _points(left, results, ladder, joined=True)
    left.set_xticks(range(len(ladder)), [ladder[0].name, *(f"+ {each.name}" for each in ladder[1:])])
    left.set_title("Changes added one by one")
    left.set_ylabel("deployed return less MARL's")
    _points(right, results, [ladder[-1], *without], joined=False)
    right.set_xticks(
        range(len(without) + 1), ["default", *(each.name.replace("without-", MINUS + " ") for each in without)]
    )
    right.set_title("The default less one change")
    for axes in (left, right):
        axes.axhline(0.0, color=TEXT_COLOUR, linewidth=1.2, linestyle="--", zorder=1)
        axes.grid(axis="x", visible=False)
        axes.tick_params(axis="x", rotation=35)
        for label in axes.get_xticklabels():
            label.set_horizontalalignment("right")
            label.set_rotation_mode("anchor")
    left.annotate(
        "MARL, given both true rewards",
        (0.01, 0.0),
        xycoords=("axes fraction", "data"),
        xytext=(0, 4),
        textcoords="offset points",
        color=FAINT_COLOUR,
        fontsize=9,
    )
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=len(results.plan.graphs))
    return figure


def _points(axes: Axes, results: AblationResults, variants: list[Variant], joined: bool) -> None:
    count = len(results.plan.graphs)
    for index, graph in enumerate(results.plan.graphs):
        cells = [results.results[graph, variant.name] for variant in variants]
        means = [Estimate.over(cell.deployed - cell.marl) for cell in cells]
        # Side by side, so that intervals do not hide each other.
        places = np.arange(len(variants)) + 0.09 * (index - (count - 1) / 2)
        middle = np.array([each.mean for each in means])
        spread = np.array([[each.mean - each.low, each.high - each.mean] for each in means]).T
        axes.errorbar(
            places,
            middle,
            yerr=spread,
            color=COLOURS[index % len(COLOURS)],
            marker=MARKERS[index % len(MARKERS)],
            markersize=5,
            linewidth=1.0,
            linestyle="-" if joined else "none",
            alpha=0.9,
            label=graph.replace("-", " "),
        )
