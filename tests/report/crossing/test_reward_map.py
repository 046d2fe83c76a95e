"""The map of the human's reward shows where each seed found the goal."""

from pathlib import Path

import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.report.crossing.reward_map import RewardMap
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs import RunFolder

X, Y = np.array([-1.0, 0.0, 2.0]), np.array([0.0, 1.0])


def map_of(folder: Path, learned: np.ndarray) -> RewardMap | None:
    """Of rewards given as [seeds, Y, X], the rows written in no order; the true one grows with x."""
    run = RunFolder.create(folder / "run", {"experiment": "crossing", "algorithm": "gsiirl"}, {"name": "g"})
    seeds = len(learned)
    run.append_metrics(0, {"seed": np.arange(seeds), "iteration": np.zeros(seeds, int)})
    seed, row, column = (each.ravel() for each in np.indices(learned.shape))
    order = np.random.default_rng(0).permutation(len(seed))
    columns = {"seed": seed, "x": X[column], "y": Y[row], "learned": learned.ravel(), "true": 10 * X[column]}
    run.save_reward_map({name: values[order] for name, values in columns.items()})
    return RewardMap.of(ReportedRun.read(run.path))


def test_each_seed_counts_alike_whatever_its_scale(tmp_path: Path) -> None:
    first = np.array([[0.0, 1.0, 2.0], [0.0, 0.0, 4.0]])
    rewards = map_of(tmp_path, np.stack([first, 100 - 10 * first]))
    assert rewards is not None
    np.testing.assert_allclose(rewards.learned, 0.5)
    np.testing.assert_allclose(rewards.true, [[0, 1 / 3, 1], [0, 1 / 3, 1]])
    np.testing.assert_array_equal(rewards.peaks, [[2, 1], [-1, 0]])


def test_the_peak_is_that_of_the_mean(tmp_path: Path) -> None:
    rewards = map_of(tmp_path, np.array([[[0.0, 3.0, 0.0], [0.0, 0.0, 0.0]]]))
    assert rewards is not None
    np.testing.assert_array_equal(rewards.peak, [0.0, 0.0])


def test_a_reward_that_is_the_same_everywhere_is_no_error(tmp_path: Path) -> None:
    rewards = map_of(tmp_path, np.full((1, 2, 3), 5.0))
    assert rewards is not None
    np.testing.assert_array_equal(rewards.learned, 0.0)


def test_a_reward_that_is_not_finite_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"reward_map.parquet: is damaged: it holds what is no number"):
        map_of(tmp_path, np.full((1, 2, 3), np.nan))
