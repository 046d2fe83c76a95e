"""One episode of physical deception: the ways of the three, and their distances to the target."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gsiirl.report.deception.recorded_episode import AGENTS, LANDMARKS, adversary_distance, agents_distance, targets
from gsiirl.report.figures.style import ALARM_COLOUR, FAINT_COLOUR, SHIELD_COLOUR
from gsiirl.report.plane import scene
from gsiirl.report.plane.episode import PlaneEpisode

AGENT_COLOURS = (SHIELD_COLOUR, "#14b8a6")
TARGET_COLOUR = "#b45309"
LANDMARK_RADIUS = 0.08


def draw_episode(episode: PlaneEpisode) -> Figure:
    """Left the ways, right the distances to the target over time."""
    figure, plane, panel = scene.draw_beside(episode, lambda axes, step: _draw_scene(axes, episode, step))
    adversary, agents = adversary_distance(episode), agents_distance(episode)
    scene.draw_values(panel, adversary, ALARM_COLOUR, "adversary")
    scene.draw_values(panel, agents, SHIELD_COLOUR, "nearer of the good agents")
    panel.fill_between(np.arange(episode.steps + 1), agents, adversary, color=FAINT_COLOUR, alpha=0.1)
    panel.set(title="Distance to the good agents' target", xlabel="step", ylabel="distance")
    panel.set_ylim(bottom=0)
    panel.legend(fontsize=9)
    figure.legend(*plane.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=9.5)
    return figure


def animate_episode(episode: PlaneEpisode) -> dict[str, bytes]:
    """The good agents and the adversary step by step."""

    def draw(axes: Axes, step: int) -> None:
        _draw_scene(axes, episode, step)
        axes.set_title(f"step {step} of {episode.steps}")
        axes.figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=3, fontsize=9)

    return scene.animate_scene(episode, draw, height=5.2, bottom=0.18)


def _draw_scene(axes: Axes, episode: PlaneEpisode, until: int) -> None:
    scene.prepare_plane(axes, scene.box_around(np.concatenate(list(episode.positions.values())), 3 * LANDMARK_RADIUS))
    target, expert_target = targets(episode)
    for index, landmark in enumerate(LANDMARKS):
        place = episode.positions[landmark][0]
        if index == target:
            text, colour = "target" if target == expert_target else "good agents' target", TARGET_COLOUR
        elif index == expert_target:
            text, colour = "adversary's target", ALARM_COLOUR
        else:
            text, colour = "decoy", FAINT_COLOUR
        # The name of the lower one stands below it: the two may be close.
        below = bool(place[1] < episode.positions[LANDMARKS[1 - index]][0, 1])
        scene.draw_place(axes, place, LANDMARK_RADIUS, colour, text, below)
    for number, (agent, colour) in enumerate(zip(AGENTS, AGENT_COLOURS, strict=True), start=1):
        scene.draw_way(axes, episode.positions[agent], until, colour, f"good agent {number}")
    scene.draw_way(axes, episode.positions["adversary"], until, ALARM_COLOUR, "adversary")
