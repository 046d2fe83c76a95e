"""How often the two collide and reach their goals, along the iterations (the paper's Figure 3, c and d)."""

from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from gsiirl.report.group import GameGroup
from gsiirl.report.learning_curves import draw_curves, draw_level, legend_handles, marl_levels, number_iterations

PANELS = (
    ("collision_rate", "They collide"),
    ("goal_rate_robot", "The robot reaches its goal"),
    ("goal_rate_human", "The human reaches its goal"),
)


def draw_rates(group: GameGroup) -> Figure | None:
    """One panel a rate, of the deployed pair; None without any curve."""
    panels = [panel for panel in PANELS if any(run.curve(panel[0]) for run in group.learners.values())]
    if not panels:
        return None
    figure = Figure(figsize=(9.6, 3.5), layout="constrained")
    for axes, (metric, title) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        draw_curves(axes, group, metric)
        for level in marl_levels(group, metric):
            draw_level(axes, level)
        axes.set_title(title)
        number_iterations(axes)
        # A band of one standard deviation may leave what a rate can be.
        axes.set_ylim(-0.03, 1.03)
        axes.yaxis.set_major_formatter(PercentFormatter(1.0))
    levels = marl_levels(group, panels[0][0])
    figure.legend(handles=legend_handles(group, levels), loc="outside upper center", ncols=4, fontsize=9.5)
    return figure
