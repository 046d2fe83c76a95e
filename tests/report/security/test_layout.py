"""Attack graphs are laid out from left to right without overlaps."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from report.synthetic import RING, SyntheticGame, dense_graph

from gsiirl.report.security.layout import CARD, lay_out, layer_graph
from gsiirl.report.security.recorded_graph import OUTSIDE, RecordedGraph


def read(graph: dict) -> RecordedGraph:
    return RecordedGraph.read(SyntheticGame(graph).content(), Path("run"))


def random_graph(seed: int, nodes: int) -> dict:
    random = np.random.default_rng(seed)
    names = [f"node {index}" for index in range(nodes)]
    pairs = {tuple(random.choice(nodes, 2, replace=False)) for _ in range(3 * nodes)}
    edges = [(names[source], names[target], 0.5) for source, target in sorted(pairs)]
    return {"nodes": names, "footholds": names[:2], "edges": [(None, names[2], 0.9), *edges]}


@pytest.mark.parametrize(
    "graph", [RING, dense_graph(), *(random_graph(seed, nodes) for seed in (0, 1) for nodes in (3, 16))]
)
def test_no_two_cards_overlap_and_all_lie_on_the_canvas(graph: dict) -> None:
    layout = lay_out(read(graph))
    half_width, half_height = CARD[0] / 2, CARD[1] / 2
    for (x1, y1), (x2, y2) in combinations(layout.position.values(), 2):
        assert abs(x1 - x2) >= CARD[0] * 0.8 or abs(y1 - y2) >= CARD[1]
    for node, (x, y) in layout.position.items():
        assert node == OUTSIDE or half_width - 1e-9 <= x <= layout.width - half_width + 1e-9
        assert half_height - 1e-9 <= y <= layout.height - half_height + 1e-9


def test_layers_count_attacks_from_the_foothold() -> None:
    layers = layer_graph(read(RING))
    assert [[RING["nodes"][node] for node in layer.nodes] for layer in layers] == [
        ["gateway"],
        ["web", "mail"],
        ["files", "staff"],
        ["build", "backup"],
        ["vault"],
    ]


def test_the_outside_comes_first_and_a_mesh_stays_together() -> None:
    layers = layer_graph(read(dense_graph()))
    assert [(layer.nodes, layer.mesh) for layer in layers] == [
        ([OUTSIDE], False),
        ([0], False),
        ([1], False),
        ([2, 3, 4, 5, 6, 7], True),
    ]


def test_what_no_attack_reaches_stands_last() -> None:
    graph = {"nodes": ["a", "b", "island"], "footholds": ["a"], "edges": [("a", "b", 0.5), ("island", "a", 0.5)]}
    assert [layer.nodes for layer in layer_graph(read(graph))] == [[0], [1], [2]]
    position = lay_out(read(graph)).position
    assert position[0][0] < position[1][0] < position[2][0]
