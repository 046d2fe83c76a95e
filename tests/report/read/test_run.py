"""A value that is not finite enters no mean and is told."""

from pathlib import Path

import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.report.page.notes import warnings
from gsiirl.report.read.group import group_runs
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs import RunFolder

METRIC = "deployed_return_learner"


def run_of(folder: Path, values: np.ndarray, metric: str = METRIC) -> ReportedRun:
    """Of a metric given as [seeds, iterations]."""
    run = RunFolder.create(folder / "run", {"experiment": "crossing", "algorithm": "gsiirl"}, {"name": "g"})
    seed, iteration = np.indices(values.shape)
    run.append_metrics(0, {"seed": seed.ravel(), "iteration": iteration.ravel(), metric: values.ravel()})
    return ReportedRun.read(run.path)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_seed_with_such_a_value_midway_is_left_out_of_the_curve_and_named(tmp_path: Path, value: float) -> None:
    run = run_of(tmp_path, np.array([[1.0, 2.0, 3.0], [9.0, value, 9.0], [3.0, 4.0, 5.0]]))
    curve = run.curve(METRIC)
    assert curve is not None
    np.testing.assert_array_equal(curve.mean, [2.0, 3.0, 4.0])
    assert run.not_finite(METRIC) == [1]
    (group,) = group_runs([run])
    assert any("deployed_return_learner (seed 1). Such a seed is left out" in each for each in warnings(group))


def test_without_a_sound_seed_there_is_no_curve(tmp_path: Path) -> None:
    run = run_of(tmp_path, np.array([[1.0, np.nan, 3.0]]))
    assert run.curve(METRIC) is None
    assert run.not_finite(METRIC) == [0]


def test_what_is_measured_from_some_iteration_on_begins_there(tmp_path: Path) -> None:
    run = run_of(tmp_path, np.array([[np.nan, np.nan, 0.1], [np.nan, np.nan, 0.3]]), "exploitability_learner")
    curve = run.curve("exploitability_learner")
    assert curve is not None
    np.testing.assert_array_equal(curve.iteration, [2])
    np.testing.assert_allclose(curve.mean, [0.2])
    assert run.not_finite("exploitability_learner") == []
    (group,) = group_runs([run])
    assert warnings(group) == [sentence for sentence in warnings(group) if "finite" not in sentence]


def test_a_damaged_file_of_learned_parameters_is_named_itself(tmp_path: Path) -> None:
    run_of(tmp_path, np.array([[1.0]]))
    (tmp_path / "run" / "learned.json").write_text("[]")
    with pytest.raises(InputError, match=r"run/learned.json: is damaged: its checksum is gone"):
        ReportedRun.read(tmp_path / "run")
