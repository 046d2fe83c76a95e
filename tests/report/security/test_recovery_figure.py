"""Scatter plots show every learned weight beside the true one."""

from pathlib import Path

import numpy as np
import pytest
from report.synthetic import RING, SyntheticGame, write_comparison

from gsiirl.report.figures.style import figure_style
from gsiirl.report.read.group import GameGroup, group_runs
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.security.recorded_graph import RecordedGraph
from gsiirl.report.security.recovery_figure import draw_recovery
from gsiirl.runs import RunFolder


@pytest.fixture(scope="module")
def group(tmp_path_factory: pytest.TempPathFactory) -> GameGroup:
    paths = write_comparison(tmp_path_factory.mktemp("runs"), failed_seed=2)
    return group_runs([ReportedRun.read(path) for path in paths])[0]


@pytest.fixture(scope="module")
def graph() -> RecordedGraph:
    return RecordedGraph.read(SyntheticGame(RING).content(), Path("run"))


def test_learned_weights_are_scaled_and_leave_failed_seeds_out(group: GameGroup, graph: RecordedGraph) -> None:
    run = group.runs["GSIIRL"]
    weights = run.weights("expert_reward")
    assert weights is not None
    stored = RunFolder.open(run.path).load_learned()
    assert stored is not None
    np.testing.assert_allclose(weights, 200.0 * stored.arrays["expert_reward"][:2])
    np.testing.assert_allclose(weights.mean(axis=0), graph.expert_truth, atol=0.3)


def test_scatter_plots_hold_every_weight_but_those_of_footholds(group: GameGroup, graph: RecordedGraph) -> None:
    with figure_style():
        figure = draw_recovery(group, graph)
    assert figure is not None
    values, costs, losses, pearson = figure.axes
    nodes, edges = len(graph.nodes) - sum(graph.footholds), len(graph.edges)
    for panel, counts in ((values, [nodes, nodes]), (costs, [edges, edges]), (losses, [nodes, edges])):
        assert [len(container[0].get_xdata()) for container in panel.containers] == counts
    assert {line.get_label() for line in pearson.lines} >= {
        "GSIIRL, attacker's reward",
        "GSIIRL, defender's dependent reward",
        "MA-IRL, attacker's reward",
    }
