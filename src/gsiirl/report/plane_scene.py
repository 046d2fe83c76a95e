"""Bodies in the plane and the way they have come."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle
from matplotlib.patheffects import withStroke

from gsiirl.report.figure_style import FAINT_COLOUR


def box_around(points: np.ndarray, margin: float) -> np.ndarray:
    """The smallest square around all points [points, 2] and a margin, as [[x0, x1], [y0, y1]]."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, float(np.max(high - low)) / 2 + margin
    return np.stack([middle - half, middle + half], axis=1)


def prepare_plane(axes: Axes, box: np.ndarray) -> None:
    """An empty plane, the same scale both ways; `box` is [[x0, x1], [y0, y1]]."""
    axes.set(xlim=tuple(box[0]), ylim=tuple(box[1]), aspect="equal", xlabel="x", ylabel="y")


def draw_way(axes: Axes, positions: np.ndarray, until: int, colour: str, label: str) -> None:
    """The way up to step `until`, a dot a step, and the body at its end."""
    way = positions[: until + 1]
    axes.plot(*way.T, color=colour, linewidth=1.4, alpha=0.75, marker="o", markersize=3, zorder=4)
    axes.plot(*way[:1].T, "o", markersize=7, markerfacecolor="white", markeredgecolor=colour, zorder=5)
    axes.plot(*way[-1:].T, "o", markersize=10, color=colour, zorder=6, label=label)


def draw_place(axes: Axes, place: np.ndarray, radius: float, colour: str, text: str, below: bool = False) -> None:
    """A round region with its name."""
    axes.add_patch(Circle((place[0], place[1]), radius, facecolor=colour, edgecolor="none", alpha=0.28, zorder=2))
    axes.add_patch(Circle((place[0], place[1]), radius, facecolor="none", edgecolor=colour, linewidth=1.4, zorder=3))
    axes.annotate(
        text,
        (place[0], place[1] + (-radius if below else radius)),
        xytext=(0, -4 if below else 4),
        textcoords="offset points",
        ha="center",
        va="top" if below else "bottom",
        color=colour,
        size=9,
        weight="bold",
        zorder=7,
        # Readable across a way.
        path_effects=[withStroke(linewidth=2.5, foreground="white")],
    )


def draw_box(axes: Axes, box: np.ndarray, colour: str, text: str) -> None:
    """A region [[x0, x1], [y0, y1]] that something starts in, with its name beneath."""
    (left, right), (low, high) = box
    region = Rectangle((left, low), right - left, high - low)
    region.set(facecolor=colour, edgecolor=colour, alpha=0.13, linewidth=0, zorder=1)
    axes.add_patch(region)
    axes.annotate(
        text,
        ((left + right) / 2, low),
        xytext=(0, -3),
        textcoords="offset points",
        ha="center",
        va="top",
        color=FAINT_COLOUR,
        size=8.5,
    )
