"""Figures show the numbers of the runs."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from report.synthetic import RING, SyntheticGame, write_comparison

from gsiirl.report.attack_graph import AttackGraph
from gsiirl.report.attack_graph_figure import draw_attack_graph
from gsiirl.report.figure_style import figure_style
from gsiirl.report.group import GameGroup, group_runs
from gsiirl.report.recovery_figure import draw_recovery
from gsiirl.report.returns_figure import draw_returns
from gsiirl.report.run import ReportedRun
from gsiirl.runs import RunFolder


@pytest.fixture(scope="module")
def group(tmp_path_factory: pytest.TempPathFactory) -> GameGroup:
    paths = write_comparison(tmp_path_factory.mktemp("runs"), failed_seed=2)
    return group_runs([ReportedRun.read(path) for path in paths])[0]


@pytest.fixture(scope="module")
def graph() -> AttackGraph:
    found = AttackGraph.read(SyntheticGame(RING).content(), Path("run"))
    assert found is not None
    return found


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def test_every_node_shows_its_true_and_its_learned_value(graph: AttackGraph) -> None:
    learned = np.linspace(-0.5, 3.0, len(graph.nodes))
    shown = texts(draw_attack_graph(graph, learned))
    for node, foothold in enumerate(graph.footholds):
        assert graph.nodes[node] in shown
        if not foothold:
            assert f"{graph.expert_truth[node]:.2f}" in shown
            assert f"{learned[node]:.2f}".replace("-", "\N{MINUS SIGN}") in shown
    assert shown.count("learned") == len(graph.nodes) - sum(graph.footholds)
    assert "foothold: held by the\nattacker from the start" in shown


def test_without_anything_learned_only_the_truth_is_shown(graph: AttackGraph) -> None:
    shown = texts(draw_attack_graph(graph, None))
    assert "learned" not in shown
    assert "what the defender learned it is worth" not in shown


def test_learned_weights_are_scaled_and_leave_failed_seeds_out(group: GameGroup, graph: AttackGraph) -> None:
    run = group.runs["GSIIRL"]
    weights = run.weights("expert_reward")
    assert weights is not None
    stored = RunFolder.open(run.path).load_learned()
    assert stored is not None
    np.testing.assert_allclose(weights, 200.0 * stored.arrays["expert_reward"][:2])
    np.testing.assert_allclose(weights.mean(axis=0), graph.expert_truth, atol=0.3)


def test_returns_are_drawn_for_both_sides_deployed_and_model(group: GameGroup) -> None:
    figure = draw_returns(group)
    assert figure is not None
    assert len(figure.axes) == 4
    deployed = {line.get_label(): line for line in figure.axes[0].lines}
    for label in ("GSIIRL", "MA-IRL"):
        curve = group.runs[label].curve("deployed_return_learner")
        assert curve is not None
        np.testing.assert_array_equal(deployed[label].get_ydata(), curve.mean)
        assert len(curve.mean) == 21
    heights = [np.ravel(line.get_ydata()) for line in figure.axes[0].lines]
    levels = [float(height[0]) for height in heights if len(height) == 2]
    assert levels == [pytest.approx(-6.3), pytest.approx(-9.6)]


def test_random_play_far_off_is_told_and_does_not_flatten_the_curves(tmp_path: Path) -> None:
    run = RunFolder.create(tmp_path / "run", {"experiment": "security", "algorithm": "gsiirl"}, {"name": "g"})
    run.append_metrics(
        0,
        {
            "seed": np.zeros(3, dtype=int),
            "iteration": np.arange(3),
            "deployed_return_learner": np.array([-5.0, -4.5, -4.0]),
            "random_return_learner": np.full(3, -80.0),
        },
    )
    figure = draw_returns(group_runs([ReportedRun.read(run.path)])[0])
    assert figure is not None
    panel = figure.axes[0]
    assert any(text.get_text().startswith("learner that plays at random: -80.00") for text in panel.texts)
    assert panel.get_ylim()[0] > -10


def test_a_run_that_strays_for_a_while_does_not_flatten_the_curves(tmp_path: Path) -> None:
    for algorithm, strayed in (("gsiirl", -5.0), ("paper", -90.0)):
        run = RunFolder.create(tmp_path / algorithm, {"experiment": "security", "algorithm": algorithm}, {"name": "g"})
        returns = np.array([-8.0, strayed, -6.0, -5.0, -5.0])
        seeds, iterations = np.zeros(5, dtype=int), np.arange(5)
        run.append_metrics(0, {"seed": seeds, "iteration": iterations, "deployed_return_learner": returns})
    runs = [ReportedRun.read(tmp_path / algorithm) for algorithm in ("gsiirl", "paper")]
    figure = draw_returns(group_runs(runs)[0])
    assert figure is not None
    low, high = figure.axes[0].get_ylim()
    assert -10 < low < -8 < -5 < high < -4


def test_scatter_plots_hold_every_weight_but_those_of_footholds(group: GameGroup, graph: AttackGraph) -> None:
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
