"""Drawing bodies in the plane, their ways, and values over the steps of an episode."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from matplotlib.patheffects import withStroke

from gsiirl.report.figures.animation import animate
from gsiirl.report.figures.style import FAINT_COLOUR
from gsiirl.report.plane.episode import PlaneEpisode

Scene = Callable[[Axes, int], None]
"""Draws an episode into axes, up to a step."""


def draw_beside(episode: PlaneEpisode, scene: Scene) -> tuple[Figure, Axes, Axes]:
    """A figure with the whole episode on the left; returns it, the axes on the left and the empty ones on the right."""
    figure = Figure(figsize=(9.6, 4.9), layout="constrained")
    plane, panel = figure.subplots(1, 2)
    scene(plane, episode.steps)
    plane.set_title("Their ways")
    return figure, plane, panel


def animate_scene(episode: PlaneEpisode, scene: Scene, height: float, bottom: float) -> dict[str, bytes]:
    """The episode step by step, as `gif`.

    The figure is `height` inches tall; its square axes begin at `bottom`, a share of the height.
    """

    def draw(step: int) -> Figure:
        figure = Figure(figsize=(4.8, height))
        scene(figure.add_axes((0.14, bottom, 0.83, 0.83 * 4.8 / height)), step)
        return figure

    return animate(draw, episode.steps + 1)


def box_around(points: np.ndarray, margin: float) -> np.ndarray:
    """The smallest square around all points [points, 2] and a margin, as [[x0, x1], [y0, y1]]."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, float(np.max(high - low)) / 2 + margin
    return np.stack([middle - half, middle + half], axis=1)


def prepare_plane(axes: Axes, box: np.ndarray) -> None:
    """Limit axes to a box [[x0, x1], [y0, y1]], with the same scale both ways."""
    axes.set(xlim=tuple(box[0]), ylim=tuple(box[1]), aspect="equal", xlabel="x", ylabel="y")
    # More numbers than these touch each other, where they have two decimals and a sign.
    axes.locator_params(nbins=6)


def draw_way(axes: Axes, positions: np.ndarray, until: int, colour: str, label: str) -> None:
    """Draw a body's way up to step `until`: a dot for each step, a hollow one at its start, the body at its end."""
    way = positions[: until + 1]
    axes.plot(*way.T, color=colour, linewidth=1.4, alpha=0.75, marker="o", markersize=3, zorder=4)
    axes.plot(*way[:1].T, "o", markersize=7, markerfacecolor="white", markeredgecolor=colour, zorder=5)
    axes.plot(*way[-1:].T, "o", markersize=10, color=colour, zorder=6, label=label)


def draw_place(axes: Axes, place: np.ndarray, radius: float, colour: str, text: str, below: bool = False) -> None:
    """Draw a round region with its name above or below."""
    x, y = place
    axes.add_patch(Circle((x, y), radius, facecolor=colour, edgecolor="none", alpha=0.28, zorder=2))
    axes.add_patch(Circle((x, y), radius, facecolor="none", edgecolor=colour, linewidth=1.4, zorder=3))
    # White around the letters, so that they can be read across a way.
    outline = [withStroke(linewidth=2.5, foreground="white")]
    look = {"color": colour, "size": 9, "weight": "bold", "zorder": 7, "path_effects": outline}
    _name(axes, text, (x, y - radius if below else y + radius), -4 if below else 4, **look)


def draw_box(axes: Axes, box: np.ndarray, colour: str, text: str) -> None:
    """Draw a region [[x0, x1], [y0, y1]] with its name below."""
    (left, right), (low, high) = box
    look = {"color": colour, "alpha": 0.13, "linewidth": 0, "zorder": 1}
    axes.add_patch(Rectangle((left, low), right - left, high - low, **look))
    _name(axes, text, ((left + right) / 2, low), -3, color=FAINT_COLOUR, size=8.5)


def draw_values(panel: Axes, values: np.ndarray, colour: str, label: str | None = None) -> None:
    """Draw values over the steps, [T + 1]."""
    panel.plot(np.arange(len(values)), values, color=colour, linewidth=2, marker="o", markersize=3.5, label=label)


def _name(axes: Axes, text: str, place: tuple[float, float], offset: int, **look: Any) -> None:
    """Write a name `offset` points above a place, or below it where the offset is negative."""
    side = "top" if offset < 0 else "bottom"
    axes.annotate(text, place, xytext=(0, offset), textcoords="offset points", ha="center", va=side, **look)
