"""Rates of collisions and of reached goals over iterations (the paper's Figure 3, c and d)."""

from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from gsiirl.report.curves.learning_curves import draw_curves, draw_legend, draw_level, marl_levels, number_iterations
from gsiirl.report.read.group import GameGroup

PANELS = {
    "collision_rate": "They collide",
    "goal_rate_robot": "The robot reaches its goal",
    "goal_rate_human": "The human reaches its goal",
}
"""Titles by metric."""


def draw_rates(group: GameGroup) -> Figure | None:
    """One panel for each rate of the deployed pair; None where no run has a curve."""
    metrics = [metric for metric in PANELS if any(run.curve(metric) for run in group.learners.values())]
    if not metrics:
        return None
    figure = Figure(figsize=(9.6, 3.5), layout="constrained")
    for axes, metric in zip(figure.subplots(1, len(metrics), squeeze=False)[0], metrics, strict=True):
        heights = draw_curves(axes, group, metric)
        for level in marl_levels(group, metric):
            draw_level(axes, level)
            heights.append(level.value)
        axes.set_title(PANELS[metric])
        number_iterations(axes)
        # The axis ends at the highest rate, so that small rates stay visible, and never above 1.
        top = min(1.0, max(0.1, *heights))
        axes.set_ylim(-0.03 * top, 1.05 * top)
        axes.yaxis.set_major_formatter(PercentFormatter(1.0))
    draw_legend(figure, group, marl_levels(group, metrics[0]))
    return figure
