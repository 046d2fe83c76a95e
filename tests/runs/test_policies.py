"""The final policies of a run come back, and a damaged file is named."""

from pathlib import Path

import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.runs import RunFolder
from gsiirl.runs.files.array_file import write_arrays

WEIGHTS = {
    "learner.layers.0.weight": np.arange(12, dtype=np.float32).reshape(2, 3, 2),
    "learner.layers.0.bias": np.ones((2, 3), np.float32),
}


@pytest.fixture
def run(tmp_path: Path) -> RunFolder:
    return RunFolder.create(tmp_path / "run", {"experiment": "deception", "algorithm": "gsiirl"}, {})


def test_weights_come_back_as_they_were(run: RunFolder) -> None:
    assert run.load_policies() is None
    run.save_policies(WEIGHTS)
    policies = run.load_policies()
    assert policies is not None
    assert policies.keys() == WEIGHTS.keys()
    for name, weights in WEIGHTS.items():
        assert policies[name].dtype == weights.dtype
        np.testing.assert_array_equal(policies[name], weights)


def test_a_damaged_file_is_named(run: RunFolder) -> None:
    run.save_policies(WEIGHTS)
    path = run.path / "policies.safetensors"
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputError, match=r"policies.safetensors: is damaged"):
        run.load_policies()


@pytest.mark.parametrize("metadata", [None, {"format_version": "99"}])
def test_a_file_of_another_format_is_named(run: RunFolder, metadata: dict[str, str] | None) -> None:
    write_arrays(run.path / "policies.safetensors", WEIGHTS, metadata)
    with pytest.raises(InputError, match=r"policies.safetensors: is damaged or of an unknown format"):
        run.load_policies()
