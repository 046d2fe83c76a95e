"""The attack graph shows the true and the learned value of every node."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from report.synthetic import RING, SyntheticGame

from gsiirl.report.security.graph_figure import draw_attack_graph
from gsiirl.report.security.recorded_graph import RecordedGraph


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
