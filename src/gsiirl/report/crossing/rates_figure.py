"""Rates of collisions and of reached goals over iterations (the paper's Figure 3, c and d)."""

from matplotlib.figure import Figure

from gsiirl.report.curves.learning_curves import CurvePanel, draw_legend, draw_panel, marl_levels, number_iterations
from gsiirl.report.read.group import GameGroup

PANELS = {
    "collision_rate": "They collide",
    "goal_rate_robot": "The robot reaches its goal",
    "goal_rate_human": "The human reaches its goal",
}
"""Titles by metric."""


def draw_rates(group: GameGroup) -> Figure | None:
    """One panel for each rate of the deployed pair; None where no run has a curve."""
    panels = rates_panels(group)
    if not panels:
        return None
    figure = Figure(figsize=(9.6, 3.5), layout="constrained")
    for axes, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        draw_panel(axes, group, panel)
        axes.set_title(panel.title)
        number_iterations(axes)
    draw_legend(figure, group, panels[0].levels)
    return figure


def rates_panels(group: GameGroup) -> list[CurvePanel]:
    """A panel for each rate that a run has."""
    panels: list[CurvePanel] = []
    for metric, title in PANELS.items():
        curves = [curve for run in group.learners.values() if (curve := run.curve(metric)) is not None]
        if curves:
            levels = marl_levels(group, metric)
            heights = [float((curve.mean + curve.std).max()) for curve in curves] + [level.value for level in levels]
            # The axis ends at the highest rate, so that small rates stay visible, and never above 1.
            top = min(1.0, max(0.1, *heights))
            panels.append(CurvePanel(metric, title, "", levels, (-0.03 * top, 1.05 * top), shares=True))
    return panels
