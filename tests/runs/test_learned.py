"""Learned parameters and sample paths come back with their names and scales."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from resealing import rewrite

from gsiirl.errors import InputError
from gsiirl.runs import RunFolder, Summary
from gsiirl.runs.learned import Interval

ARRAYS = {"expert_reward": np.array([[0.5, 0.1], [0.4, 0.2]]), "commitment": np.array([[0.3], [0.2]])}
SCALES = {"expert_reward": 4.0, "commitment": 1.0}
NAMES = {"expert_reward": ["value of a", "cost of outside -> a"], "commitment": ["c"]}


@pytest.fixture
def run(tmp_path: Path) -> RunFolder:
    return RunFolder.create(tmp_path / "run", {"experiment": "security", "algorithm": "gsiirl"}, {})


def test_weights_are_scale_times_parameter(run: RunFolder) -> None:
    assert run.load_learned() is None
    run.save_learned(ARRAYS, SCALES, NAMES, seeds=[3, 5])
    learned = run.load_learned()
    assert learned is not None
    assert learned.seeds == [3, 5]
    assert learned.names == NAMES
    np.testing.assert_array_equal(learned.weights("expert_reward"), [[2.0, 0.4], [1.6, 0.8]])


INTERVAL = Interval(0.9, [1.5, 0.1], [2.5, 0.9], [True, False])


def test_intervals_come_back_where_there_is_a_posterior(run: RunFolder) -> None:
    run.save_learned(ARRAYS, SCALES, NAMES, [3, 5], {"expert_reward": [INTERVAL, None]})
    learned = run.load_learned()
    assert learned is not None
    assert learned.intervals == {"expert_reward": [INTERVAL, None]}
    run.save_learned(ARRAYS, SCALES, NAMES, [3, 5])
    learned = run.load_learned()
    assert learned is not None
    assert learned.intervals == {}


@pytest.mark.parametrize("intervals", [[INTERVAL], [INTERVAL, replace(INTERVAL, low=[1.5])]])
def test_intervals_of_other_seeds_or_weights_are_damaged(run: RunFolder, intervals: list[Interval | None]) -> None:
    run.save_learned(ARRAYS, SCALES, NAMES, [3, 5], {"expert_reward": intervals})
    with pytest.raises(InputError, match="is damaged: expert_reward has intervals for other"):
        run.load_learned()


def test_the_same_parameters_give_the_same_bytes(run: RunFolder) -> None:
    run.save_learned(ARRAYS, SCALES, NAMES, seeds=[3, 5])
    before = [(run.path / name).read_bytes() for name in ("learned.json", "learned.safetensors")]
    run.save_learned(ARRAYS, SCALES, NAMES, seeds=[3, 5])
    assert before == [(run.path / name).read_bytes() for name in ("learned.json", "learned.safetensors")]


def test_arrays_that_do_not_fit_their_names_are_refused(run: RunFolder) -> None:
    with pytest.raises(ValueError, match="commitment has shape"):
        run.save_learned({**ARRAYS, "commitment": np.zeros((2, 2))}, SCALES, NAMES, seeds=[3, 5])
    with pytest.raises(ValueError, match="differ"):
        run.save_learned(ARRAYS, {"expert_reward": 4.0}, NAMES, seeds=[3, 5])
    assert run.load_learned() is None


def test_a_description_that_does_not_fit_the_arrays_is_damaged(run: RunFolder) -> None:
    run.save_learned(ARRAYS, SCALES, NAMES, seeds=[3, 5])
    path = run.path / "learned.json"
    for old, new in (('"c"', '"c", "d"'), ('"commitment"', '"missing"'), ('"scale": 4.0', '"scale": "4.0"')):
        run.save_learned(ARRAYS, SCALES, NAMES, seeds=[3, 5])
        rewrite(path, old, new)
        with pytest.raises(InputError, match=r"learned.json: (is damaged|commitment does not fit)"):
            run.load_learned()


def test_a_missing_array_file_is_named(run: RunFolder) -> None:
    run.save_learned(ARRAYS, SCALES, NAMES, seeds=[3, 5])
    (run.path / "learned.safetensors").unlink()
    with pytest.raises(InputError, match=r"learned.safetensors: cannot be read"):
        run.load_learned()


def test_sample_paths_come_back(run: RunFolder) -> None:
    assert run.paths() is None
    columns = {name: np.arange(4) for name in ("seed", "trajectory", "step", "state", "learner_action")}
    run.save_paths(columns)
    paths = run.paths()
    assert paths is not None
    assert {name: paths[name].to_list() for name in paths.columns} == {name: [0, 1, 2, 3] for name in columns}


def summary_of(seeds: list[int], failed: list[int]) -> Summary:
    return Summary("security", "gsiirl", seeds, failed, 0, completed=True, final={})


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e101])
def test_only_a_seed_that_failed_may_have_learned_what_is_no_number(run: RunFolder, value: float) -> None:
    broken = {**ARRAYS, "commitment": np.array([[0.3], [value]])}
    run.save_learned(broken, SCALES, NAMES, seeds=[3, 5])
    run.save_policies(broken)
    run.write_summary(summary_of([3, 5], [5]))
    assert run.load_learned() is not None
    assert run.load_policies() is not None
    run.write_summary(summary_of([3, 5], []))
    for read in (run.load_learned, run.load_policies):
        with pytest.raises(InputError, match=r"safetensors: is damaged: commitment holds what is no number"):
            read()


def test_what_was_learned_by_other_seeds_is_damage(run: RunFolder) -> None:
    run.save_learned(ARRAYS, SCALES, NAMES, seeds=[3, 5])
    run.save_policies({"learner": np.zeros((3, 2)), "expert": np.array(0.0)})
    run.write_summary(summary_of([3, 4], []))
    with pytest.raises(InputError, match=r"learned.json: is damaged: it is not of the seeds of summary.json"):
        run.load_learned()
    with pytest.raises(InputError, match=r"policies.safetensors: is damaged: it is not of all seeds"):
        run.load_policies()


@pytest.mark.parametrize("seed", [[0.0, 0.0], [7, 7]])
def test_sample_paths_of_other_seeds_are_damage(run: RunFolder, seed: list[float]) -> None:
    run.write_summary(summary_of([0], []))
    index = {"trajectory": np.array([0, 0]), "step": np.array([0, 1])}
    run.save_paths({"seed": np.array(seed), **index, "x": np.array([0.0, np.nan])})
    with pytest.raises(
        InputError, match=r"paths.parquet: is damaged: it (is not of the seeds|holds what is no number)"
    ):
        run.paths()
