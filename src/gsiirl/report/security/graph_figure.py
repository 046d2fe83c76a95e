"""The attack graph with the true and the learned value of each node (the paper's Figure 4, left)."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.bezier import BezierSegment
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Rectangle
from matplotlib.text import Text

from gsiirl.report.figures import style
from gsiirl.report.figures.style import Look
from gsiirl.report.security.layout import CARD, OUTSIDE_CARD, lay_out
from gsiirl.report.security.recorded_graph import OUTSIDE, RecordedGraph
from gsiirl.report.words.numbers import format_number

EDGE_COLOUR = "#64748b"
LABELLED_EDGES = 14
"""With more edges than these, none carries its probability: the labels would hide the graph."""
MARGIN, LEGEND_HEIGHT = 0.2, 0.5
LABEL = (0.36, 0.18)
"""Room that a probability takes."""
LEGEND_WIDTH = 10.4
SAMPLES = 81
BENDS = (0.0, 0.15, -0.15, 0.3, -0.3, 0.45, -0.45, 0.6)
MUTUAL_BENDS = (0.12, 0.25, 0.4, 0.55)
"""Of an edge that has one the other way: bent to the same side of their own direction, the two part."""
LAST_BEND = 0.7
CENTRED: Look = {"ha": "center", "va": "center"}

Point = tuple[float, float]


@dataclass(frozen=True)
class _EdgeCurve:
    """A quadratic Bezier curve from a card's centre to another's."""

    points: np.ndarray
    """Sampled, [SAMPLES, 2]."""
    rad: float
    """The bend of matplotlib's connection style arc3."""


def draw_attack_graph(graph: RecordedGraph, learned_value: np.ndarray | None, untested: Collection[int] = ()) -> Figure:
    """Draw the graph; `learned_value` is the mean over seeds, [N], or None where nothing was learned.

    What was learned of the nodes in `untested` is pale.
    """
    layout = lay_out(graph)
    curves = _edge_curves(graph, layout.position)
    # Edges that go a long way round may leave the canvas of the cards.
    reach = np.concatenate([curve.points for curve in curves] + [np.array([[0, 0], [layout.width, layout.height]])])
    (left, bottom), (right, top) = reach.min(axis=0), reach.max(axis=0)
    side = MARGIN + max(0.0, LEGEND_WIDTH - (right - left)) / 2
    figure = Figure(figsize=(right - left + 2 * side, top - bottom + 2 * MARGIN + LEGEND_HEIGHT))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(left - side, right + side)
    axes.set_ylim(bottom - MARGIN - LEGEND_HEIGHT, top + MARGIN)
    values = {"true": (graph.expert_truth[: len(graph.nodes)], style.TRUE_COLOUR)}
    if learned_value is not None:
        values["learned"] = (learned_value, style.LEARNED_COLOUR)
    cards = {
        node: _draw_outside(axes, place)
        if node == OUTSIDE
        else _draw_node(axes, graph, node, place, values, pale=node in untested)
        for node, place in layout.position.items()
    }
    for (source, target), probability, curve in zip(graph.edges, graph.success_probability, curves, strict=True):
        ends: Look = {"patchA": cards[source], "patchB": cards[target], "shrinkA": 1, "shrinkB": 2}
        ends["connectionstyle"] = f"arc3,rad={curve.rad}"
        arrow = FancyArrowPatch(layout.position[source], layout.position[target], **ends, **_arrow(probability))
        axes.add_patch(arrow)
        if len(graph.edges) <= LABELLED_EDGES:
            others = [place for node, place in layout.position.items() if node not in (source, target)]
            x, y = _label_place(curve, OUTSIDE_CARD if source == OUTSIDE else CARD, others)
            look = CENTRED | {"bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.8}}
            axes.text(x, y, f"{probability:.0%}", size=8.5, color=style.FAINT_COLOUR, **look)
    _draw_legend(axes, learned_value is not None, bottom - MARGIN - LEGEND_HEIGHT / 2)
    return figure


def _draw_card(axes: Axes, place: Point, size: Point, rounding: float, **look: Any) -> FancyBboxPatch:
    corner = (place[0] - size[0] / 2, place[1] - size[1] / 2)
    card = FancyBboxPatch(corner, *size, boxstyle=f"round,pad=0,rounding_size={rounding}", zorder=3, **look)
    axes.add_patch(card)
    return card


def _draw_outside(axes: Axes, place: Point) -> FancyBboxPatch:
    x, y = place
    card = _draw_card(axes, place, OUTSIDE_CARD, 0.21, facecolor=style.TEXT_COLOUR, edgecolor="none")
    axes.text(x, y, "outside", size=11, weight="bold", color="white", zorder=4, **CENTRED)
    axes.text(x, y - 0.3, "the attacker\nstarts here", size=9, color=style.FAINT_COLOUR, ha="center", va="top")
    return card


def _draw_node(
    axes: Axes, graph: RecordedGraph, node: int, place: Point, values: dict[str, tuple[np.ndarray, str]], pale: bool
) -> FancyBboxPatch:
    """A card with the node's name and a bar for each of its `values` (and its colour), by label; returns the card."""
    (x, y), (width, height) = place, CARD
    left, right, name = x - width / 2 + 0.09, x + width / 2 - 0.07, graph.nodes[node]
    foothold = graph.footholds[node]
    edge, width_of_edge = (style.ALARM_COLOUR, 2.2) if foothold else ("#94a3b8", 1.0)
    card = _draw_card(axes, place, CARD, 0.08, facecolor="white", edgecolor=edge, linewidth=width_of_edge)
    heading = axes.text(left, y + height / 2 - 0.17, name, size=10.5, weight="bold", va="center", zorder=4)
    _fit(heading, right - left)
    if foothold:
        # The attacker gains nothing by taking what it holds: its value has no effect and cannot be learned.
        text = "foothold: held by the\nattacker from the start"
        axes.text(left, y - 0.12, text, size=9, color=style.ALARM_COLOUR, va="center", zorder=4)
        return card
    if not graph.can_fall(node):
        text = "cannot be reached:\nnothing to learn"
        axes.text(left, y - 0.12, text, size=9, color=style.FAINT_COLOUR, va="center", zorder=4)
        return card
    gainable = [graph.can_fall(other) for other in range(len(graph.nodes))]
    longest = max(float(np.max(np.abs(each[gainable]))) for each, _ in values.values()) or 1.0
    # Long numbers take from the bars' room, and lose decimals that nobody compares.
    digits = 2 if longest < 100 else 1 if longest < 1000 else 0
    letters = max(len(format_number(float(number), digits)) for each, _ in values.values() for number in each[gainable])
    room = max(0.08, 0.46 - 0.09 * max(0, letters - 4))
    for row, (label, (each, colour)) in enumerate(values.items()):
        look: Look = {"color": colour, "alpha": 0.35 if pale and label == "learned" else 1.0}
        middle = y + height / 2 - 0.43 - 0.24 * row
        axes.text(left, middle, label, size=9, va="center", zorder=4, **look)
        start = (x - width / 2 + 0.61, middle - 0.07)
        filled = room * min(1.0, max(0.0, float(each[node])) / longest)
        axes.add_patch(Rectangle(start, room, 0.14, facecolor="#f1f5f9", zorder=4))
        axes.add_patch(Rectangle(start, filled, 0.14, linewidth=0, zorder=5, **look))
        text = format_number(float(each[node]), digits)
        axes.text(right, middle, text, size=9.5, weight="bold", ha="right", va="center", zorder=5, **look)
    return card


def _fit(text: Text, width: float) -> None:
    """Shrink a text to a width in inches."""
    figure = text.get_figure()
    assert figure is not None
    drawn = text.get_window_extent().width / figure.dpi
    if drawn > width:
        text.set_fontsize(float(text.get_fontsize()) * width / drawn)


def _edge_curves(graph: RecordedGraph, position: dict[int, Point]) -> list[_EdgeCurve]:
    """A curve for each edge: of those not yet taken the one that crosses fewest cards, then the straightest."""
    chosen: list[_EdgeCurve] = []
    taken: set[tuple[int, int, float]] = set()
    for source, target in graph.edges:
        bends = MUTUAL_BENDS if (target, source) in graph.edges else BENDS
        free = [rad for rad in bends if (source, target, rad) not in taken] or [LAST_BEND]
        candidates = [_edge_curve(position[source], position[target], rad) for rad in free]
        others = [place for node, place in position.items() if node not in (source, target)]
        best = min(candidates, key=lambda curve, others=others: (_cards_hit(curve, others), abs(curve.rad)))
        taken.add((source, target, best.rad))
        chosen.append(best)
    return chosen


def _edge_curve(start: Point, end: Point, rad: float) -> _EdgeCurve:
    (x1, y1), (x2, y2) = start, end
    control = ((x1 + x2) / 2 + rad * (y2 - y1), (y1 + y2) / 2 - rad * (x2 - x1))
    return _EdgeCurve(BezierSegment(np.array([start, control, end]))(np.linspace(0, 1, SAMPLES)), rad)


def _label_place(curve: _EdgeCurve, source_card: Point, others: list[Point]) -> np.ndarray:
    """A point of the part between the cards, off all others, nearer to the tail: the head must be seen."""
    from_source, from_target = curve.points - curve.points[0], curve.points - curve.points[-1]
    hidden = np.all(np.abs(from_source) < np.array(source_card) / 2, axis=1)
    hidden |= np.all(np.abs(from_target) < np.array(CARD) / 2, axis=1)
    visible = curve.points[~hidden]
    if not len(visible):
        return curve.points[len(curve.points) // 2]
    best = visible[int(0.4 * len(visible))]
    room = np.array(CARD) / 2 + np.array(LABEL) / 2
    free = [point for point in visible if not any(np.all(np.abs(point - place) < room) for place in others)]
    return min(free, key=lambda point: float(np.linalg.norm(point - best)), default=best)


def _cards_hit(curve: _EdgeCurve, others: list[Point]) -> int:
    half = np.array(CARD) / 2 + 0.04
    return sum(bool(np.any(np.all(np.abs(curve.points - np.array(place)) < half, axis=1))) for place in others)


def _arrow(probability: float) -> Look:
    return {
        "arrowstyle": f"-|>,head_length={0.32 + 0.14 * probability},head_width={0.14 + 0.1 * probability}",
        "mutation_scale": 14,
        "linewidth": 0.6 + 2.6 * probability,
        "color": EDGE_COLOUR,
        "alpha": 0.75,
        "zorder": 2,
    }


def _draw_legend(axes: Axes, learned: bool, y: float) -> None:
    x = axes.get_xlim()[0] + MARGIN
    axes.plot([x, axes.get_xlim()[1] - MARGIN], [y + 0.24] * 2, color=style.LINE_COLOUR, linewidth=0.8)
    entries = [("what the node is worth to the attacker", style.TRUE_COLOUR)]
    if learned:
        entries.append(("what the defender learned it is worth", style.LEARNED_COLOUR))
    for text, colour in entries:
        axes.add_patch(Rectangle((x, y - 0.06), 0.26, 0.12, facecolor=colour))
        axes.text(x + 0.33, y, text, size=10, va="center")
        x += 0.33 + 0.074 * len(text) + 0.15
    axes.add_patch(FancyArrowPatch((x, y), (x + 0.4, y), **_arrow(0.3)))
    axes.add_patch(FancyArrowPatch((x + 0.45, y), (x + 0.95, y), **_arrow(0.9)))
    axes.text(x + 1.03, y, "attack; thicker: likelier to succeed", size=10, va="center")
