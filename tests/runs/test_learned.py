"""Learned parameters and sample paths come back with their names and scales."""

from pathlib import Path

import numpy as np
import pytest
from resealing import rewrite

from gsiirl.errors import InputError
from gsiirl.runs import RunFolder

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
