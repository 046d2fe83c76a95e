"""One encounter of robot and human: their ways and their distance (the paper's Figure 3, e and f)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from gsiirl.report.animation import Animation, animate
from gsiirl.report.crossing import Crossing
from gsiirl.report.figure_style import ALARM_COLOUR, FAINT_COLOUR, SHIELD_COLOUR, TEXT_COLOUR
from gsiirl.report.plane_episode import PlaneEpisode, distances
from gsiirl.report.plane_scene import box_around, draw_box, draw_place, draw_way, prepare_plane

ROBOT_COLOUR, HUMAN_COLOUR = SHIELD_COLOUR, ALARM_COLOUR


def closeness(episode: PlaneEpisode) -> float:
    """The smallest distance that robot and human come to."""
    return float(np.min(_apart(episode)))


def draw_crossing(crossing: Crossing, episode: PlaneEpisode) -> Figure:
    """Left the ways, right the distance over time."""
    figure = Figure(figsize=(9.6, 4.9), layout="constrained")
    plane, panel = figure.subplots(1, 2)
    _draw_scene(plane, crossing, episode, episode.steps)
    nearest = int(np.argmin(_apart(episode)))
    ends = np.stack([episode.positions["robot"][nearest], episode.positions["human"][nearest]])
    plane.plot(*ends.T, color=TEXT_COLOUR, linewidth=1.2, linestyle=":", zorder=3)
    plane.set_title("Their ways")
    plane.legend(loc="upper right", fontsize=9, title="hollow: where they start", title_fontsize=8.5)
    _draw_distance(panel, crossing, episode, nearest)
    return figure


def animate_crossing(crossing: Crossing, episode: PlaneEpisode) -> Animation:
    """Robot and human step by step, with the distance that the robot should keep around it."""

    def draw(step: int) -> Figure:
        figure = Figure(figsize=(4.8, 4.8))
        axes = figure.add_axes((0.14, 0.11, 0.83, 0.83))
        _draw_scene(axes, crossing, episode, step)
        robot = episode.positions["robot"][step]
        too_close = _apart(episode)[step] < crossing.safe_distance
        circle = Circle((robot[0], robot[1]), crossing.safe_distance, facecolor="none", linestyle="--", zorder=3)
        circle.set(edgecolor=ALARM_COLOUR if too_close else FAINT_COLOUR, linewidth=1.2)
        axes.add_patch(circle)
        axes.set_title(f"step {step} of {episode.steps}, {_apart(episode)[step]:.2f} apart")
        axes.legend(loc="upper right", fontsize=9)
        return figure

    return animate(draw, episode.steps + 1)


def _apart(episode: PlaneEpisode) -> np.ndarray:
    return distances(episode.positions["robot"], episode.positions["human"])


def _draw_scene(axes: Axes, crossing: Crossing, episode: PlaneEpisode, until: int) -> None:
    # Who has not learned yet may leave the arena.
    prepare_plane(axes, box_around(np.concatenate([crossing.arena.T, *episode.positions.values()]), 0.0))
    draw_box(axes, crossing.robot_start, ROBOT_COLOUR, "robot starts")
    draw_box(axes, crossing.human_start, HUMAN_COLOUR, "human starts")
    draw_place(axes, crossing.robot_goal, crossing.goal_radius, ROBOT_COLOUR, "robot's goal")
    draw_place(axes, crossing.human_goal, crossing.goal_radius, HUMAN_COLOUR, "human's goal", below=True)
    draw_way(axes, episode.positions["robot"], until, ROBOT_COLOUR, "robot")
    draw_way(axes, episode.positions["human"], until, HUMAN_COLOUR, "human")


def _draw_distance(panel: Axes, crossing: Crossing, episode: PlaneEpisode, nearest: int) -> None:
    apart = _apart(episode)
    panel.plot(np.arange(len(apart)), apart, color=TEXT_COLOUR, linewidth=2, marker="o", markersize=3.5)
    lines = (
        (crossing.safe_distance, FAINT_COLOUR, "--", "safe distance"),
        (crossing.collision_distance, ALARM_COLOUR, "-", "collision"),
    )
    for height, colour, line, text in lines:
        panel.axhline(height, color=colour, linewidth=1.4, linestyle=line)
        panel.annotate(
            f"{text} ({height:g})",
            (1, height),
            xycoords=("axes fraction", "data"),
            xytext=(-2, 3),
            textcoords="offset points",
            ha="right",
            color=colour,
            size=9,
        )
    panel.plot(nearest, apart[nearest], "o", markersize=10, markerfacecolor="none", markeredgecolor=TEXT_COLOUR)
    panel.set_ylim(0, 1.05 * max(float(np.max(apart)), crossing.safe_distance))
    panel.set(title=f"Distance between the two, at least {apart[nearest]:.2f}", xlabel="step", ylabel="distance")
