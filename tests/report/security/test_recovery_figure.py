"""Scatter plots show every learned weight beside the true one."""

from dataclasses import replace
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


def test_bars_are_the_intervals_of_a_seed_and_what_is_not_determined_is_grey(
    group: GameGroup, graph: RecordedGraph
) -> None:
    run = group.runs["GSIIRL"]
    weights = run.weights("expert_reward")
    assert weights is not None
    node = int(np.flatnonzero([graph.can_fall(each) for each in range(len(graph.nodes))])[0])
    deviation = np.full(weights.shape[1], 0.1)
    deviation[node] = 0.6
    spread = np.linspace(-1.0, 1.0, 101)[None, :, None] * np.sqrt(3.0) * deviation
    drawn = replace(
        run, expert_draws=weights[:, None, :] + spread, final=run.final | {"prior_deviation": np.full(2, 1.0 / 200.0)}
    )
    with figure_style():
        figure = draw_recovery(replace(group, runs={"GSIIRL": drawn}), graph)
    assert figure is not None
    known, unknown = figure.axes[0].containers
    np.testing.assert_allclose(unknown[0].get_xdata(), [graph.expert_truth[node]])
    assert unknown.get_label() == "GSIIRL, not determined"
    assert unknown[2] == ()
    bars = np.array([each[:, 1] for each in known[2][0].get_segments()])
    # From the 5 % to the 95 % quantile of a uniform distribution of deviation 0.1.
    np.testing.assert_allclose(bars[:, 1] - bars[:, 0], 0.9 * 2 * 0.1 * np.sqrt(3.0), rtol=0.03)


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
