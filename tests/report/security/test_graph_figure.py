"""The attack graph shows the true and the learned value of every node."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Rectangle
from report.synthetic import RING, SyntheticGame

from gsiirl.report.security.graph_figure import draw_attack_graph
from gsiirl.report.security.recorded_graph import RecordedGraph
from gsiirl.scenarios import random_network


@pytest.fixture(scope="module")
def graph() -> RecordedGraph:
    return RecordedGraph.read(SyntheticGame(RING).content(), Path("run"))


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_every_node_shows_its_true_and_its_learned_value(graph: RecordedGraph) -> None:
    learned = np.linspace(-0.5, 3.0, len(graph.nodes))
    shown = texts(draw_attack_graph(graph, learned))
    for node, foothold in enumerate(graph.footholds):
        assert graph.nodes[node] in shown
        if not foothold:
            assert f"{graph.expert_truth[node]:.2f}" in shown
            assert f"{learned[node]:.2f}".replace("-", "\N{MINUS SIGN}") in shown
    assert shown.count("learned") == len(graph.nodes) - sum(graph.footholds)
    assert "foothold: held by the\nattacker from the start" in shown


def test_without_anything_learned_only_the_truth_is_shown(graph: RecordedGraph) -> None:
    shown = texts(draw_attack_graph(graph, None))
    assert "learned" not in shown
    assert "what the defender learned it is worth" not in shown


@pytest.mark.parametrize("scale", [1, 10, 300, 40_000])
def test_names_and_numbers_keep_to_their_cards(scale: float) -> None:
    names = ["gateway", "WORKSTATION WEST", "Domain controller", *RING["nodes"][3:]]
    renamed = dict(zip(RING["nodes"], names, strict=True))
    edges = [(renamed[source], renamed[target], chance) for source, target, chance in RING["edges"]]
    graph = RecordedGraph.read(SyntheticGame(RING | {"nodes": names, "edges": edges}).content(), Path("run"))
    graph.expert_truth[:] *= scale
    figure = draw_attack_graph(graph, -1.03 * graph.expert_truth[: len(names)])
    (axes,) = figure.axes
    cards = [patch.get_window_extent() for patch in axes.patches if isinstance(patch, FancyBboxPatch)]
    bars = [patch.get_window_extent() for patch in axes.patches if type(patch) is Rectangle and patch.zorder == 4]
    numbers = 0
    for text in axes.texts:
        extent = text.get_window_extent()
        number = text.get_text().replace("\N{MINUS SIGN}", "").replace(".", "").isdigit()
        if text.get_text() in names or number:
            assert any(card.x0 <= extent.x0 and extent.x1 <= card.x1 for card in cards if card.overlaps(extent))
        if number:
            numbers += 1
            assert not any(bar.overlaps(extent) for bar in bars), text.get_text()
    assert numbers == 14


def test_probabilities_keep_off_the_cards_of_others() -> None:
    network = random_network(0)
    names = list(network.node_names)
    edges = [
        (names[source], names[target], chance)
        for source, target, chance in zip(
            network.edge_source, network.edge_target, network.success_probability, strict=True
        )
    ]
    footholds = [names[node] for node in network.footholds]
    content = SyntheticGame({"nodes": names, "footholds": footholds, "edges": edges}).content()
    figure = draw_attack_graph(RecordedGraph.read(content, Path("run")), None)
    (axes,) = figure.axes
    cards = [patch.get_window_extent() for patch in axes.patches if isinstance(patch, FancyBboxPatch)]
    labels = [text.get_window_extent() for text in axes.texts if text.get_text().endswith("%")]
    assert len(labels) == len(edges)
    assert not any(card.overlaps(label) for card in cards for label in labels)
