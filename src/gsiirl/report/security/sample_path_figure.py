"""A timeline of one trajectory: both actions of every step, and the nodes that fell."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from gsiirl.report.figures.style import ALARM_COLOUR, FAINT_COLOUR, LINE_COLOUR, SHIELD_COLOUR, TEXT_COLOUR
from gsiirl.report.security.recorded_graph import RecordedGraph
from gsiirl.report.security.sample_path import SamplePath

OUTCOMES = {
    "taken": ("succeeds", ALARM_COLOUR),
    "blocked": ("blocked", SHIELD_COLOUR),
    "failed": ("fails", FAINT_COLOUR),
    "wasted": ("no effect", FAINT_COLOUR),
    "idle": ("waits", FAINT_COLOUR),
    "unknown": ("end", FAINT_COLOUR),
}
"""Words and colours."""


def draw_sample_path(graph: RecordedGraph, path: SamplePath) -> Figure:
    """Columns are steps; above, the two actions and the outcome; below, the nodes that the attacker holds."""
    steps, nodes = len(path.steps), len(graph.nodes)
    longest = max(max(len(name) for name in graph.nodes), 12)
    labels = 0.085 * longest + 0.25
    column = max(0.8, 0.062 * max(len(part) for step in path.steps for part in step.attack.split(" → ")) + 0.2)
    rows = 3.1 + 0.34 * nodes
    figure = Figure(figsize=(labels + column * steps + 0.15, rows * 0.62 + 0.3))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(-labels / column, steps + 0.15 / column)
    axes.set_ylim(rows - 0.1, -0.35)
    for y, text in ((0.0, "step"), (0.75, "attacker attacks"), (1.6, "defender blocks"), (2.35, "the attack")):
        axes.text(-0.12, y, text, ha="right", va="center", size=9, color=FAINT_COLOUR)
    for number, step in enumerate(path.steps):
        middle = number + 0.5
        text, colour = OUTCOMES[step.outcome]
        _write(axes, middle, 0.0, str(number + 1), color=FAINT_COLOUR)
        for y, action, side in ((0.75, step.attack, ALARM_COLOUR), (1.6, step.block, SHIELD_COLOUR)):
            _write(axes, middle, y, action.replace(" → ", " →\n"), size=7.8, color=side, linespacing=1.25)
        _write(axes, middle, 2.35, text, weight="bold", color=colour)
        for node in range(nodes):
            held, new = node in step.compromised, node in step.fallen
            colour = (ALARM_COLOUR if new else "#fca5a5") if held else "#f1f5f9"
            place = (number + 0.04, 2.92 + 0.34 * node)
            axes.add_patch(Rectangle(place, 0.92, 0.28, facecolor=colour, edgecolor="none"))
            if new:
                _write(axes, middle, 3.06 + 0.34 * node, "falls", size=8, color="white")
    for node, name in enumerate(graph.nodes):
        axes.text(-0.12, 3.06 + 0.34 * node, name, ha="right", va="center", size=9, color=TEXT_COLOUR)
    axes.plot([-labels / column + 0.1, steps], [2.68, 2.68], color=LINE_COLOUR, linewidth=0.8)
    return figure


def _write(axes: Axes, x: float, y: float, text: str, **look: Any) -> None:
    axes.text(x, y, text, **{"ha": "center", "va": "center", "size": 9, **look})
