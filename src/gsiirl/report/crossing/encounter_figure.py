"""One encounter of robot and human: their ways and their distance (the paper's Figure 3, e and f)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from gsiirl.report.crossing.recorded_crossing import RecordedCrossing
from gsiirl.report.figures.style import ALARM_COLOUR, FAINT_COLOUR, SHIELD_COLOUR, TEXT_COLOUR
from gsiirl.report.plane import scene
from gsiirl.report.plane.episode import PlaneEpisode, distances

ROBOT_COLOUR, HUMAN_COLOUR = SHIELD_COLOUR, ALARM_COLOUR


def smallest_distance(episode: PlaneEpisode) -> float:
    """The smallest distance of robot and human in an encounter."""
    return float(np.min(_apart(episode)))


def draw_encounter(crossing: RecordedCrossing, episode: PlaneEpisode) -> Figure:
    """Left the ways, right the distance over time."""
    figure, plane, panel = scene.draw_beside(episode, lambda axes, step: _draw_scene(axes, crossing, episode, step))
    nearest = int(np.argmin(_apart(episode)))
    ends = np.stack([episode.positions["robot"][nearest], episode.positions["human"][nearest]])
    plane.plot(*ends.T, color=TEXT_COLOUR, linewidth=1.2, linestyle=":", zorder=3)
    plane.legend(loc="upper right", fontsize=9, title="hollow: where they start", title_fontsize=8.5)
    _draw_distance(panel, crossing, _apart(episode))
    return figure


def animate_encounter(crossing: RecordedCrossing, episode: PlaneEpisode) -> dict[str, bytes]:
    """Robot and human step by step, with the safe distance as a ring around the robot."""

    def draw(axes: Axes, step: int) -> None:
        _draw_scene(axes, crossing, episode, step)
        apart, (x, y) = _apart(episode)[step], episode.positions["robot"][step]
        colour = ALARM_COLOUR if apart < crossing.safe_distance else FAINT_COLOUR
        look = {"facecolor": "none", "edgecolor": colour, "linestyle": "--", "linewidth": 1.2, "zorder": 3}
        axes.add_patch(Circle((x, y), crossing.safe_distance, **look))
        axes.set_title(f"step {step} of {episode.steps}, {apart:.2f} apart")
        axes.legend(loc="upper right", fontsize=9)

    return scene.animate_scene(episode, draw, height=4.8, bottom=0.11)


def _apart(episode: PlaneEpisode) -> np.ndarray:
    """The distance of the two at every step, [T + 1]."""
    return distances(episode.positions["robot"], episode.positions["human"])


def _draw_scene(axes: Axes, crossing: RecordedCrossing, episode: PlaneEpisode, until: int) -> None:
    # An untrained robot may leave the arena.
    scene.prepare_plane(axes, scene.box_around(np.concatenate([crossing.arena.T, *episode.positions.values()]), 0.0))
    scene.draw_box(axes, crossing.robot_start, ROBOT_COLOUR, "robot starts")
    scene.draw_box(axes, crossing.human_start, HUMAN_COLOUR, "human starts")
    scene.draw_place(axes, crossing.robot_goal, crossing.goal_radius, ROBOT_COLOUR, "robot's goal")
    scene.draw_place(axes, crossing.human_goal, crossing.goal_radius, HUMAN_COLOUR, "human's goal", below=True)
    scene.draw_way(axes, episode.positions["robot"], until, ROBOT_COLOUR, "robot")
    scene.draw_way(axes, episode.positions["human"], until, HUMAN_COLOUR, "human")


def _draw_distance(panel: Axes, crossing: RecordedCrossing, apart: np.ndarray) -> None:
    scene.draw_values(panel, apart, TEXT_COLOUR)
    lines = (
        (crossing.safe_distance, FAINT_COLOUR, "--", "safe distance"),
        (crossing.collision_distance, ALARM_COLOUR, "-", "collision"),
    )
    offset = {"xycoords": ("axes fraction", "data"), "xytext": (-2, 3), "textcoords": "offset points"}
    for height, colour, line, text in lines:
        panel.axhline(height, color=colour, linewidth=1.4, linestyle=line)
        panel.annotate(f"{text} ({height:g})", (1, height), ha="right", color=colour, size=9, **offset)
    nearest = int(np.argmin(apart))
    panel.plot(nearest, apart[nearest], "o", markersize=10, markerfacecolor="none", markeredgecolor=TEXT_COLOUR)
    panel.set_ylim(0, 1.05 * max(float(np.max(apart)), crossing.safe_distance))
    panel.set(title=f"Distance between the two, at least {apart[nearest]:.2f}", xlabel="step", ylabel="distance")
