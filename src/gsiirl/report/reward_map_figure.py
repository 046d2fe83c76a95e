"""The human's learned reward beside the true one, over the plane."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gsiirl.report.crossing import Crossing
from gsiirl.report.figure_style import TEXT_COLOUR
from gsiirl.report.plane_scene import prepare_plane
from gsiirl.report.reward_map import RewardMap

COLOURS = "Blues"


def draw_reward_map(crossing: Crossing, rewards: RewardMap) -> Figure:
    """Left as learned, right as it is; the darker, the better for the human."""
    figure = Figure(figsize=(9.6, 4.9), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    image = None
    for panel, values, title in (
        (panels[0], rewards.learned, "As the robot learned it"),
        (panels[1], rewards.true, "As it is"),
    ):
        prepare_plane(panel, crossing.arena)
        panel.grid(visible=False)
        image = panel.pcolormesh(
            rewards.x, rewards.y, values, shading="nearest", cmap=COLOURS, vmin=0, vmax=1, rasterized=True
        )
        panel.contour(rewards.x, rewards.y, values, levels=np.linspace(0.1, 0.9, 9), colors="white", linewidths=0.6)
        _mark(panel, crossing.human_goal, "*", 17, "white", "the human's true goal")
        panel.set_title(title)
    # Seeds that agree lie on each other.
    panels[0].plot(
        *rewards.peaks.T,
        "x",
        color="#ea580c",
        markersize=8,
        markeredgewidth=2,
        label="highest learned reward, each seed",
    )
    _mark(panels[0], rewards.peak, "o", 15, "none", "highest mean learned reward")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=9.5)
    figure.colorbar(image, ax=panels, label="human's reward, lowest 0, highest 1", shrink=0.85)
    return figure


def _mark(panel: Axes, place: np.ndarray, marker: str, size: float, face: str, label: str) -> None:
    edge = "#ea580c" if face == "none" else TEXT_COLOUR
    panel.plot(
        place[0],
        place[1],
        marker,
        markersize=size,
        markerfacecolor=face,
        markeredgecolor=edge,
        markeredgewidth=1.6 if face == "none" else 1.0,
        linestyle="none",
        label=label,
        zorder=5,
    )
