"""The human's learned reward beside the true one, over the plane."""

import numpy as np
from matplotlib.figure import Figure

from gsiirl.report.crossing.recorded_crossing import RecordedCrossing
from gsiirl.report.crossing.reward_map import RewardMap
from gsiirl.report.figures.style import TEXT_COLOUR
from gsiirl.report.plane.scene import prepare_plane

COLOURS = "Blues"
PEAK_COLOUR = "#ea580c"
STAR = {"markersize": 17, "markerfacecolor": "white", "markeredgecolor": TEXT_COLOUR, "markeredgewidth": 1.0}
CIRCLE = {"markersize": 15, "markerfacecolor": "none", "markeredgecolor": PEAK_COLOUR, "markeredgewidth": 1.6}


def draw_reward_map(crossing: RecordedCrossing, rewards: RewardMap) -> Figure:
    """Left the learned reward, right the true one; the darker, the better for the human."""
    figure = Figure(figsize=(9.6, 4.9), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    x, y = rewards.x, rewards.y
    for panel, values, title in zip(
        panels, (rewards.learned, rewards.true), ("As the robot learned it", "As it is"), strict=True
    ):
        prepare_plane(panel, crossing.arena)
        panel.grid(visible=False)
        panel.pcolormesh(x, y, values, shading="nearest", cmap=COLOURS, vmin=0, vmax=1, rasterized=True)
        panel.contour(x, y, values, levels=np.linspace(0.1, 0.9, 9), colors="white", linewidths=0.6)
        panel.plot(*crossing.human_goal, "*", linestyle="none", label="the human's true goal", zorder=5, **STAR)
        panel.set_title(title)
    # The crosses of seeds that agree lie on each other.
    cross = {"color": PEAK_COLOUR, "markersize": 8, "markeredgewidth": 2}
    panels[0].plot(*rewards.peaks.T, "x", label="highest learned reward, each seed", **cross)
    panels[0].plot(*rewards.peak, "o", linestyle="none", label="highest mean learned reward", zorder=5, **CIRCLE)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=9.5)
    figure.colorbar(panels[1].collections[0], ax=panels, label="human's reward, lowest 0, highest 1", shrink=0.85)
    return figure
