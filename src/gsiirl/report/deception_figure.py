"""One episode of physical deception: the ways of the three, and who is nearer to the target."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gsiirl.report.animation import Animation, animate
from gsiirl.report.deception import AGENTS, LANDMARKS, adversary_distance, agents_distance, targets
from gsiirl.report.figure_style import ALARM_COLOUR, FAINT_COLOUR, SHIELD_COLOUR
from gsiirl.report.plane_episode import PlaneEpisode
from gsiirl.report.plane_scene import box_around, draw_place, draw_way, prepare_plane

AGENT_COLOURS = (SHIELD_COLOUR, "#14b8a6")
TARGET_COLOUR = "#b45309"
LANDMARK_RADIUS = 0.08


def draw_deception(episode: PlaneEpisode) -> Figure:
    """Left the ways, right the distances to the target over time."""
    figure = Figure(figsize=(9.6, 4.9), layout="constrained")
    plane, panel = figure.subplots(1, 2)
    _draw_scene(plane, episode, episode.steps)
    plane.set_title("Their ways")
    steps = np.arange(episode.steps + 1)
    for heights, colour, text in (
        (adversary_distance(episode), ALARM_COLOUR, "adversary"),
        (agents_distance(episode), SHIELD_COLOUR, "nearer of the good agents"),
    ):
        panel.plot(steps, heights, color=colour, linewidth=2, marker="o", markersize=3.5, label=text)
    panel.fill_between(steps, agents_distance(episode), adversary_distance(episode), color=FAINT_COLOUR, alpha=0.1)
    panel.set(title="Distance to the good agents' target", xlabel="step", ylabel="distance")
    panel.set_ylim(bottom=0)
    panel.legend(fontsize=9)
    figure.legend(*plane.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=9.5)
    return figure


def animate_deception(episode: PlaneEpisode) -> Animation:
    """The three step by step."""

    def draw(step: int) -> Figure:
        figure = Figure(figsize=(4.8, 5.2))
        axes = figure.add_axes((0.14, 0.18, 0.83, 0.83 * 4.8 / 5.2))
        _draw_scene(axes, episode, step)
        axes.set_title(f"step {step} of {episode.steps}")
        figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=3, fontsize=9)
        return figure

    return animate(draw, episode.steps + 1)


def _draw_scene(axes: Axes, episode: PlaneEpisode, until: int) -> None:
    prepare_plane(axes, box_around(np.concatenate(list(episode.positions.values())), 3 * LANDMARK_RADIUS))
    target, expert_target = targets(episode)
    for index, landmark in enumerate(LANDMARKS):
        place = episode.positions[landmark][0]
        if index == target == expert_target:
            text, colour = "target", TARGET_COLOUR
        elif index == target:
            text, colour = "good agents' target", TARGET_COLOUR
        elif index == expert_target:
            text, colour = "adversary's target", ALARM_COLOUR
        else:
            text, colour = "decoy", FAINT_COLOUR
        # The lower one's name beneath it: the two may stand close.
        below = bool(place[1] < episode.positions[LANDMARKS[1 - index]][0, 1])
        draw_place(axes, place, LANDMARK_RADIUS, colour, text, below)
    for number, (agent, colour) in enumerate(zip(AGENTS, AGENT_COLOURS, strict=True), start=1):
        draw_way(axes, episode.positions[agent], until, colour, f"good agent {number}")
    draw_way(axes, episode.positions["adversary"], until, ALARM_COLOUR, "adversary")
