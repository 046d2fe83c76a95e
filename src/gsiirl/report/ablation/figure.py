"""The figure of an ablation: the return of each variant against MARL's."""

import numpy as np
from matplotlib.figure import Figure

from gsiirl.report.ablation.results import AblationResults
from gsiirl.report.figures.style import FAINT_COLOUR, TEXT_COLOUR, Look
from gsiirl.report.read.estimate import Estimate

COLOURS = ("#2563eb", "#d97706", "#0d9488", "#be185d", "#475569", "#65a30d", "#7c2d12")
MARKERS = "osD^vPX"


def draw_ablation(results: AblationResults) -> Figure:
    """Deployed return less MARL's, from the paper's preset to the default; one line for each graph."""
    first, *changes = results.plan.variants
    figure = Figure(figsize=(9.6, 4.4), layout="constrained")
    axes = figure.subplots()
    count = len(results.plan.graphs)
    for index, graph in enumerate(results.plan.graphs):
        cells = [results.results[graph, variant.name] for variant in results.plan.variants]
        means = [Estimate.over(cell.deployed - cell.marl) for cell in cells]
        # Side by side, so that intervals do not hide each other.
        places = np.arange(len(cells)) + 0.07 * (index - (count - 1) / 2)
        spread = np.array([[each.mean - each.low, each.high - each.mean] for each in means]).T
        look: Look = {"color": COLOURS[index % len(COLOURS)], "marker": MARKERS[index % len(MARKERS)]}
        look |= {"markersize": 5, "linewidth": 1.2, "label": graph.replace("-", " ")}
        axes.errorbar(places, [each.mean for each in means], yerr=spread, **look)
    axes.set_xticks(range(len(changes) + 1), [first.name, *(f"+ {each.name}" for each in changes)])
    axes.set_ylabel("deployed return less MARL's")
    axes.grid(axis="x", visible=False)
    axes.axhline(0.0, color=TEXT_COLOUR, linewidth=1.2, linestyle="--", zorder=1)
    offset = {"xycoords": ("axes fraction", "data"), "xytext": (0, 5), "textcoords": "offset points"}
    look = {"horizontalalignment": "right", "color": FAINT_COLOUR, "fontsize": 9}
    axes.annotate("MARL, given both true rewards", (0.995, 0.0), **offset, **look)
    axes.legend(loc="lower right", ncols=3)
    return figure
