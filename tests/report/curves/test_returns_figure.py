"""The figure of the returns shows the numbers of the runs."""

from pathlib import Path

import numpy as np
import pytest
from report.synthetic import write_comparison

from gsiirl.report.curves.returns_figure import draw_returns
from gsiirl.report.read.group import GameGroup, group_runs
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs import RunFolder


@pytest.fixture(scope="module")
def group(tmp_path_factory: pytest.TempPathFactory) -> GameGroup:
    paths = write_comparison(tmp_path_factory.mktemp("runs"), failed_seed=2)
    return group_runs([ReportedRun.read(path) for path in paths])[0]


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
    assert any(text.get_text().startswith("learner that plays at random: \N{MINUS SIGN}80.00") for text in panel.texts)
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


def test_marl_by_another_solver_is_a_line_of_its_own(plane_runs: dict[str, list[Path]]) -> None:
    group = group_runs([ReportedRun.read(path) for path in plane_runs["deception"]])[0]
    figure = draw_returns(group)
    assert figure is not None
    maddpg = group.runs["MARL (MADDPG)"].estimate("deployed_return_learner")
    assert maddpg is not None
    levels = [line for line in figure.axes[0].lines if len(np.ravel(line.get_xdata())) == 2]
    assert [np.ravel(line.get_ydata())[0] for line in levels[:2]] == [pytest.approx(8.9), pytest.approx(maddpg.mean)]
    assert {text.get_text() for text in figure.legends[0].texts} >= {"MARL, given both true rewards", "MARL (MADDPG)"}
