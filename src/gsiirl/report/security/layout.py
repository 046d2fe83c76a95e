"""Where the nodes of an attack graph stand: the attacker's start on the left, what is farthest from it on the right."""

import math
from dataclasses import dataclass

import networkx
import numpy as np

from gsiirl.report.security.recorded_graph import OUTSIDE, RecordedGraph

CARD = (1.58, 0.86)
"""Width and height of a node's card, inches."""
OUTSIDE_CARD = (0.95, 0.42)
"""Width and height of the card of the outside, inches."""
COLUMN_GAP, ROW_GAP = 0.62, 0.5
MESH = 4
"""Smallest number of nodes that stand on a ring if they all attack each other."""


@dataclass(frozen=True)
class GraphLayout:
    """Centre of every card, inches, from the lower left corner of a canvas of the given size."""

    position: dict[int, tuple[float, float]]
    """By node, and by `OUTSIDE`."""
    width: float
    height: float


@dataclass(frozen=True)
class GraphLayer:
    """Nodes that stand together."""

    nodes: list[int]
    mesh: bool
    """Whether they all attack each other."""


def layer_graph(graph: RecordedGraph) -> list[GraphLayer]:
    """Nodes by the number of successful attacks that reach them, `OUTSIDE` first where there are entry edges.

    The largest mesh (a subnet, say) stays together, at the distance of its nearest node.
    """
    distance = _distances(graph)
    mesh = _largest_mesh(graph)
    nearest = min((distance[node] for node in mesh), default=0)
    layers: dict[tuple[int, bool], list[int]] = {}
    for node in distance:
        key = (nearest, True) if node in mesh else (distance[node], False)
        layers.setdefault(key, []).append(node)
    return [GraphLayer(nodes, mesh=key[1]) for key, nodes in sorted(layers.items())]


def lay_out(graph: RecordedGraph) -> GraphLayout:
    """Layers as columns, a mesh as a ring so that its edges stay apart."""
    layers = _ordered(graph, layer_graph(graph))
    blocks = [_ring(len(layer.nodes)) if layer.mesh else _column(len(layer.nodes)) for layer in layers]
    height = max(float(np.ptp(block[:, 1])) for block in blocks) + CARD[1]
    position: dict[int, tuple[float, float]] = {}
    left = 0.0
    for layer, block in zip(layers, blocks, strict=True):
        card_width = OUTSIDE_CARD[0] if layer.nodes == [OUTSIDE] else CARD[0]
        middle = left + (float(np.ptp(block[:, 0])) + card_width) / 2 - (block[:, 0].max() + block[:, 0].min()) / 2
        for node, (x, y) in zip(layer.nodes, block, strict=True):
            position[node] = (float(middle + x), height / 2 + float(y))
        left += float(np.ptp(block[:, 0])) + card_width + COLUMN_GAP
    return GraphLayout(position, left - COLUMN_GAP, height)


def _distances(graph: RecordedGraph) -> dict[int, int]:
    """Number of attacks from the attacker's start to every node; nodes that none reaches come last."""
    entries: dict[int, int] = {OUTSIDE: 0} if any(source == OUTSIDE for source, _ in graph.edges) else {}
    last = max(graph.distance.values(), default=0) + 1
    return entries | {node: graph.distance.get(node, last) for node in range(len(graph.nodes))}


def _largest_mesh(graph: RecordedGraph) -> list[int]:
    """The largest set of at least `MESH` nodes that all attack each other, of equals the first; else []."""
    mutual = networkx.DiGraph(graph.edges).to_undirected(reciprocal=True)
    cliques: list[list[int]] = [sorted(clique) for clique in networkx.find_cliques(mutual)]
    largest = min(cliques, key=lambda clique: (-len(clique), clique), default=[])
    return largest if len(largest) >= MESH else []


def _column(count: int) -> np.ndarray:
    """Centres [count, 2] of a column; a slight bow keeps the edges inside a column off its middle cards."""
    y = (np.arange(count)[::-1] - (count - 1) / 2) * (CARD[1] + ROW_GAP)
    x = 0.35 * (np.arange(count) % 2 - 0.5) if count > 2 else np.zeros(count)
    return np.stack([x, y], axis=1)


def _ring(count: int) -> np.ndarray:
    """Centres [count, 2] of a ring that begins on the left."""
    angle = math.pi - 2 * math.pi * np.arange(count) / count
    radius = max(1.0, count / 5)
    return np.stack([1.85 * radius * np.cos(angle), 1.7 * radius * np.sin(angle)], axis=1)


def _ordered(graph: RecordedGraph, layers: list[GraphLayer]) -> list[GraphLayer]:
    """Layers with their nodes in an order that makes few edges cross (barycentre heuristic).

    Each node stands near the mean height of its sources in the layer before; a ring begins with the node that the
    layer before attacks most.
    """
    ordered = layers[:1]
    for layer in layers[1:]:
        before = ordered[-1].nodes
        height = {node: place / max(1, len(before) - 1) for place, node in enumerate(before)}
        near = {
            node: [height[source] for source, target in graph.edges if target == node and source in height]
            for node in layer.nodes
        }
        rank = {node: -len(each) if layer.mesh else np.mean(each or [0.5]) for node, each in near.items()}
        ordered.append(GraphLayer(sorted(layer.nodes, key=lambda node, rank=rank: (rank[node], node)), layer.mesh))
    return ordered
