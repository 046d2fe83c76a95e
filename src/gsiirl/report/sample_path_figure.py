"""A timeline of one trajectory: who tried what, and which nodes fell."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from gsiirl.report.attack_graph import AttackGraph
from gsiirl.report.figure_style import ALARM_COLOUR, FAINT_COLOUR, LINE_COLOUR, SHIELD_COLOUR, TEXT_COLOUR
from gsiirl.report.sample_path import SamplePath

OUTCOMES = {
    "taken": ("succeeds", ALARM_COLOUR),
    "blocked": ("blocked", SHIELD_COLOUR),
    "failed": ("fails", FAINT_COLOUR),
    "wasted": ("no effect", FAINT_COLOUR),
    "idle": ("waits", FAINT_COLOUR),
    "unknown": ("end", FAINT_COLOUR),
}


def draw_sample_path(graph: AttackGraph, path: SamplePath) -> Figure:
    """Columns are steps; above, the two actions and the outcome; below, which nodes the attacker holds."""
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
    headings = ((0.0, "step"), (0.75, "attacker attacks"), (1.6, "defender blocks"), (2.35, "the attack"))
    for y, text in headings:
        axes.text(-0.12, y, text, ha="right", va="center", size=9, color=FAINT_COLOUR)
    for number, step in enumerate(path.steps):
        middle = number + 0.5
        text, colour = OUTCOMES[step.outcome]
        axes.text(middle, 0.0, str(number + 1), ha="center", va="center", size=9, color=FAINT_COLOUR)
        _draw_action(axes, middle, 0.75, step.attack, ALARM_COLOUR)
        _draw_action(axes, middle, 1.6, step.block, SHIELD_COLOUR)
        axes.text(middle, 2.35, text, ha="center", va="center", size=9, weight="bold", color=colour)
        for node in range(nodes):
            held, new = node in step.compromised, node in step.fallen
            cell = Rectangle((number + 0.04, 2.92 + 0.34 * node), 0.92, 0.28)
            cell.set(facecolor=(ALARM_COLOUR if new else "#fca5a5") if held else "#f1f5f9", edgecolor="none")
            axes.add_patch(cell)
            if new:
                axes.text(middle, 3.06 + 0.34 * node, "falls", ha="center", va="center", size=8, color="white")
    for node, name in enumerate(graph.nodes):
        axes.text(-0.12, 3.06 + 0.34 * node, name, ha="right", va="center", size=9, color=TEXT_COLOUR)
    axes.plot([-labels / column + 0.1, steps], [2.68, 2.68], color=LINE_COLOUR, linewidth=0.8)
    return figure


def _draw_action(axes: Axes, x: float, y: float, action: str, colour: str) -> None:
    axes.text(x, y, action.replace(" → ", " →\n"), ha="center", va="center", size=7.8, color=colour, linespacing=1.25)
