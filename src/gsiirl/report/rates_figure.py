"""How often the two collide and reach their goals, along the iterations (the paper's Figure 3, c and d)."""

from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from gsiirl.report.group import GameGroup
from gsiirl.report.learning_curves import (
    draw_curves,
    draw_level,
    legend_columns,
    legend_handles,
    marl_levels,
    number_iterations,
)

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
        heights = draw_curves(axes, group, metric)
        for level in marl_levels(group, metric):
            draw_level(axes, level)
            heights.append(level.value)
        axes.set_title(title)
        number_iterations(axes)
        # What is rare is drawn large; a band of one standard deviation may leave what a share can be.
        top = min(1.0, max(0.1, *heights))
        axes.set_ylim(-0.03 * top, 1.05 * top)
        axes.yaxis.set_major_formatter(PercentFormatter(1.0))
    handles = legend_handles(group, marl_levels(group, panels[0][0]))
    figure.legend(handles=handles, loc="outside upper center", ncols=legend_columns(handles), fontsize=9.5)
    return figure
