"""Where the nodes of an attack graph stand: from the attacker's start on the left to what is farthest on the right."""

import math
from dataclasses import dataclass

import networkx
import numpy as np

from gsiirl.report.attack_graph import AttackGraph

OUTSIDE = -1
"""Key of the outside world in a layout."""
CARD = (1.58, 0.86)
"""Width and height of a node's card, inches."""
OUTSIDE_CARD = (0.95, 0.42)
"""The same of the outside world's."""
COLUMN_GAP, ROW_GAP = 0.62, 0.5
MESH = 4
"""From so many nodes on that all attack each other, they stand on a ring."""


@dataclass(frozen=True)
class Layout:
    """Centre of every card, inches, from the lower left corner of a canvas of the given size."""

    position: dict[int, tuple[float, float]]
    width: float
    height: float


@dataclass(frozen=True)
class Layer:
    """Nodes that stand together."""

    nodes: list[int]
    mesh: bool
    """Whether they all attack each other."""


def layer_graph(graph: AttackGraph) -> list[Layer]:
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
    return [Layer(nodes, mesh=key[1]) for key, nodes in sorted(layers.items())]


def lay_out(graph: AttackGraph) -> Layout:
    """Layers as columns, a mesh as a ring, so that its edges stay apart."""
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
    return Layout(position, left - COLUMN_GAP, height)


def _distances(graph: AttackGraph) -> dict[int, int]:
    network = networkx.DiGraph()
    network.add_edges_from((OUTSIDE if source is None else source, target) for source, target in graph.edges)
    start = "start"
    network.add_edges_from((start, node) for node, foothold in enumerate(graph.footholds) if foothold)
    nodes = list(range(len(graph.nodes)))
    if OUTSIDE in network:
        network.add_edge(start, OUTSIDE)
        nodes.insert(0, OUTSIDE)
    network.add_node(start)
    reached = networkx.single_source_shortest_path_length(network, start)
    # What no attack can reach stands on the right.
    return {node: reached.get(node, max(reached.values()) + 1) for node in nodes}


def _largest_mesh(graph: AttackGraph) -> list[int]:
    # An attack from outside has no way back.
    edges = {(source, target) for source, target in graph.edges if source is not None}
    mutual = networkx.Graph((source, target) for source, target in edges if (target, source) in edges)
    cliques: list[list[int]] = [sorted(clique) for clique in networkx.find_cliques(mutual)]
    largest = min(cliques, key=lambda clique: (-len(clique), clique), default=[])
    return largest if len(largest) >= MESH else []


def _column(count: int) -> np.ndarray:
    y = (np.arange(count)[::-1] - (count - 1) / 2) * (CARD[1] + ROW_GAP)
    # A slight bow keeps the edges inside a column off its middle cards.
    x = 0.35 * (np.arange(count) % 2 - 0.5) if count > 2 else np.zeros(count)
    return np.stack([x, y], axis=1)


def _ring(count: int) -> np.ndarray:
    angle = math.pi - 2 * math.pi * np.arange(count) / count
    radius = max(1.0, count / 5)
    return np.stack([1.85 * radius * np.cos(angle), 1.7 * radius * np.sin(angle)], axis=1)


def _ordered(graph: AttackGraph, layers: list[Layer]) -> list[Layer]:
    # Barycentre heuristic: each node near the mean height of its neighbours in the layer before.
    ordered = [layers[0]]
    for layer in layers[1:]:
        before = ordered[-1].nodes
        height = {node: place / max(1, len(before) - 1) for place, node in enumerate(before)}

        def sort_key(node: int, height: dict[int, float] = height, mesh: bool = layer.mesh) -> tuple[float, int]:
            sources = [OUTSIDE if source is None else source for source, target in graph.edges if target == node]
            near = [height[source] for source in sources if source in height]
            if mesh:
                # A ring begins on the left, with what the layer before attacks.
                return (-len(near), node)
            return (float(np.mean(near)) if near else 0.5, node)

        ordered.append(Layer(sorted(layer.nodes, key=sort_key), layer.mesh))
    return ordered
