"""The attack graph, each node with its true and its learned value (the paper's Figure 4, left)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Rectangle

from gsiirl.report.attack_graph import AttackGraph
from gsiirl.report.attack_graph_layout import CARD, OUTSIDE, OUTSIDE_CARD, lay_out
from gsiirl.report.figure_style import ALARM_COLOUR, FAINT_COLOUR, LEARNED_COLOUR, LINE_COLOUR, TEXT_COLOUR, TRUE_COLOUR

EDGE_COLOUR = "#64748b"
LABELLED_EDGES = 14
"""More edges than these carry no figures of their own: they would hide the graph."""
MARGIN, LEGEND_HEIGHT = 0.2, 0.5
LEGEND_WIDTH = 10.4
SAMPLES = 81

Points = dict[int, tuple[float, float]]


@dataclass(frozen=True)
class _Curve:
    """A quadratic Bezier curve from a card's centre to another's."""

    points: np.ndarray
    """Sampled, [SAMPLES, 2]."""
    rad: float


def draw_attack_graph(graph: AttackGraph, learned_value: np.ndarray | None) -> Figure:
    """Draw the graph; `learned_value` is the mean over seeds, [N], or None where nothing was learned."""
    layout = lay_out(graph)
    curves = _curves(graph, layout.position)
    # Long ways round may leave the cards' canvas.
    reach = np.concatenate([curve.points for curve in curves] + [np.array([[0, 0], [layout.width, layout.height]])])
    (left, bottom), (right, top) = reach.min(axis=0), reach.max(axis=0)
    side = MARGIN + max(0.0, LEGEND_WIDTH - (right - left)) / 2
    figure = Figure(figsize=(right - left + 2 * side, top - bottom + 2 * MARGIN + LEGEND_HEIGHT))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(left - side, right + side)
    axes.set_ylim(bottom - MARGIN - LEGEND_HEIGHT, top + MARGIN)
    cards = {node: _draw_card(axes, graph, node, layout.position, learned_value) for node in layout.position}
    for edge, (source, target) in enumerate(graph.edges):
        probability = graph.success_probability[edge]
        axes.add_patch(
            FancyArrowPatch(
                layout.position[OUTSIDE if source is None else source],
                layout.position[target],
                patchA=cards[OUTSIDE if source is None else source],
                patchB=cards[target],
                shrinkA=1,
                shrinkB=2,
                connectionstyle=f"arc3,rad={curves[edge].rad}",
                **_arrow(probability),
            )
        )
        if len(graph.edges) <= LABELLED_EDGES:
            x, y = _label_place(curves[edge], OUTSIDE_CARD if source is None else CARD)
            box = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
            axes.text(x, y, f"{probability:.0%}", size=8.5, color=FAINT_COLOUR, ha="center", va="center", bbox=box)
    _draw_legend(axes, learned_value is not None, bottom - MARGIN - LEGEND_HEIGHT / 2)
    return figure


def _draw_card(
    axes: Axes, graph: AttackGraph, node: int, position: Points, learned_value: np.ndarray | None
) -> FancyBboxPatch:
    x, y = position[node]
    width, height = CARD
    if node == OUTSIDE:
        card = FancyBboxPatch(
            (x - OUTSIDE_CARD[0] / 2, y - OUTSIDE_CARD[1] / 2),
            *OUTSIDE_CARD,
            boxstyle="round,pad=0,rounding_size=0.21",
            zorder=3,
        )
        card.set(facecolor=TEXT_COLOUR, edgecolor="none")
        axes.add_patch(card)
        axes.text(x, y, "outside", size=11, weight="bold", color="white", ha="center", va="center", zorder=4)
        axes.text(x, y - 0.3, "the attacker\nstarts here", size=9, color=FAINT_COLOUR, ha="center", va="top")
        return card
    foothold = graph.footholds[node]
    card = FancyBboxPatch(
        (x - width / 2, y - height / 2), width, height, boxstyle="round,pad=0,rounding_size=0.08", zorder=3
    )
    card.set(facecolor="white", edgecolor=ALARM_COLOUR if foothold else "#94a3b8", linewidth=2.2 if foothold else 1.0)
    axes.add_patch(card)
    axes.text(
        x - width / 2 + 0.09,
        y + height / 2 - 0.17,
        _shortened(graph.nodes[node]),
        size=10.5,
        weight="bold",
        va="center",
        zorder=4,
    )
    if foothold:
        # Nothing can be gained by taking what is held already: its value has no effect and cannot be learned.
        text = "foothold: held by the\nattacker from the start"
        axes.text(x - width / 2 + 0.09, y - 0.12, text, size=9, color=ALARM_COLOUR, va="center", zorder=4)
        return card
    true = graph.expert_truth[: len(graph.nodes)]
    rows = [("true", true, TRUE_COLOUR)]
    if learned_value is not None:
        rows.append(("learned", learned_value, LEARNED_COLOUR))
    gainable = ~np.array(graph.footholds)
    longest = max(float(np.max(np.abs(values[gainable]))) for _, values, _ in rows) or 1.0
    for row, (label, values, colour) in enumerate(rows):
        middle = y + height / 2 - 0.43 - 0.24 * row
        axes.text(x - width / 2 + 0.09, middle, label, size=9, color=colour, va="center", zorder=4)
        left, room = x - width / 2 + 0.61, 0.46
        axes.add_patch(Rectangle((left, middle - 0.07), room, 0.14, facecolor="#f1f5f9", zorder=4))
        filled = room * min(1.0, max(0.0, float(values[node])) / longest)
        axes.add_patch(Rectangle((left, middle - 0.07), filled, 0.14, facecolor=colour, zorder=5))
        axes.text(
            x + width / 2 - 0.07,
            middle,
            f"{values[node]:.2f}".replace("-", "\N{MINUS SIGN}"),
            size=9.5,
            weight="bold",
            color=colour,
            ha="right",
            va="center",
            zorder=5,
        )
    return card


def _curves(graph: AttackGraph, position: Points) -> list[_Curve]:
    ends = [(OUTSIDE if source is None else source, target) for source, target in graph.edges]
    chosen: list[_Curve] = []
    taken: set[tuple[int, int, float]] = set()
    for source, target in ends:
        # Both ways bent to the same side of their own direction: they part.
        bends = (0.12, 0.25, 0.4, 0.55) if (target, source) in ends else (0.0, 0.15, -0.15, 0.3, -0.3, 0.45, -0.45, 0.6)
        candidates = [
            _curve(position[source], position[target], rad) for rad in bends if (source, target, rad) not in taken
        ] or [_curve(position[source], position[target], 0.7)]
        others = [place for node, place in position.items() if node not in (source, target)]
        best = min(candidates, key=lambda curve: (_cards_hit(curve, others), abs(curve.rad)))
        taken.add((source, target, best.rad))
        chosen.append(best)
    return chosen


def _curve(start: tuple[float, float], end: tuple[float, float], rad: float) -> _Curve:
    # The control point is that of matplotlib's arc3 connection style.
    (x1, y1), (x2, y2) = start, end
    control = np.array([(x1 + x2) / 2 + rad * (y2 - y1), (y1 + y2) / 2 - rad * (x2 - x1)])
    t = np.linspace(0, 1, SAMPLES)[:, None]
    points = (1 - t) ** 2 * np.array(start) + 2 * t * (1 - t) * control + t**2 * np.array(end)
    return _Curve(points, rad)


def _label_place(curve: _Curve, source_card: tuple[float, float]) -> np.ndarray:
    # In the part between the cards, nearer to the tail: the head must be seen.
    from_source, from_target = curve.points - curve.points[0], curve.points - curve.points[-1]
    hidden = np.all(np.abs(from_source) < np.array(source_card) / 2, axis=1)
    hidden |= np.all(np.abs(from_target) < np.array(CARD) / 2, axis=1)
    visible = curve.points[~hidden]
    return visible[int(0.4 * len(visible))] if len(visible) else curve.points[len(curve.points) // 2]


def _cards_hit(curve: _Curve, others: list[tuple[float, float]]) -> int:
    half = np.array(CARD) / 2 + 0.04
    return sum(bool(np.any(np.all(np.abs(curve.points - np.array(place)) < half, axis=1))) for place in others)


def _arrow(probability: float) -> dict[str, Any]:
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
    axes.plot([x, axes.get_xlim()[1] - MARGIN], [y + 0.24] * 2, color=LINE_COLOUR, linewidth=0.8)
    entries = [("what the node is worth to the attacker", TRUE_COLOUR)]
    if learned:
        entries.append(("what the defender learned it is worth", LEARNED_COLOUR))
    for text, colour in entries:
        axes.add_patch(Rectangle((x, y - 0.06), 0.26, 0.12, facecolor=colour))
        axes.text(x + 0.33, y, text, size=10, va="center")
        x += 0.33 + 0.074 * len(text) + 0.15
    axes.add_patch(FancyArrowPatch((x, y), (x + 0.4, y), **_arrow(0.3)))
    axes.add_patch(FancyArrowPatch((x + 0.45, y), (x + 0.95, y), **_arrow(0.9)))
    axes.text(x + 1.03, y, "attack; thicker: likelier to succeed", size=10, va="center")


def _shortened(name: str) -> str:
    return name if len(name) <= 17 else name[:16] + "\N{HORIZONTAL ELLIPSIS}"
