"""A checkpoint gives back what was put in, or says what is wrong with it."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from resealing import resealed

from gsiirl.errors import InputError
from gsiirl.runs import RunFolder
from gsiirl.runs.checkpoint import read_checkpoint, write_checkpoint

ARRAYS = {
    "key": np.array([[1, 2**32 - 1]], dtype=np.uint32),
    "parameters": np.array([[0.1, -0.0, np.nan]]),
    "count": np.array(2**62, dtype=np.int64),
    "full": np.array([True, False]),
    "gap": np.full((), 0.1 + 0.2),
    "small": np.array([1.5], dtype=np.float32),
    "empty": np.zeros((0, 4)),
    "columns_first": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    "strided": np.arange(10)[::2],
}


@pytest.fixture
def run(tmp_path: Path) -> RunFolder:
    return RunFolder.create(tmp_path / "run", {"experiment": "security", "algorithm": "gsiirl"}, {})


def test_every_array_comes_back_bit_for_bit(run: RunFolder) -> None:
    run.save_checkpoint(ARRAYS, iteration=20, chunks=2)
    checkpoint = run.load_checkpoint()
    assert checkpoint is not None
    assert (checkpoint.iteration, checkpoint.chunks) == (20, 2)
    assert checkpoint.arrays.keys() == ARRAYS.keys()
    for name, array in ARRAYS.items():
        loaded = checkpoint.arrays[name]
        assert (loaded.dtype, loaded.shape) == (array.dtype, array.shape), name
        assert loaded.tobytes() == array.tobytes(), name


def test_there_is_none_before_the_first(run: RunFolder) -> None:
    assert run.load_checkpoint() is None


def test_a_newer_one_replaces_the_older(run: RunFolder) -> None:
    run.save_checkpoint({"state": np.zeros(2)}, iteration=1, chunks=1)
    run.save_checkpoint({"other": np.ones(2)}, iteration=2, chunks=2)
    checkpoint = run.load_checkpoint()
    assert checkpoint is not None
    assert checkpoint.iteration == 2
    assert list(checkpoint.arrays) == ["other"]


def test_the_same_state_gives_the_same_bytes_in_every_process(tmp_path: Path) -> None:
    program = (
        "import sys, numpy, pathlib; from gsiirl.runs.checkpoint import write_checkpoint; "
        "write_checkpoint(pathlib.Path(sys.argv[1]), {'b': numpy.ones(3), 'a': numpy.arange(2)}, 7, 1)"
    )
    contents = set()
    for name in ("one", "two", "three"):
        subprocess.run([sys.executable, "-c", program, str(tmp_path / name)], check=True)
        contents.add((tmp_path / name).read_bytes())
    write_checkpoint(tmp_path / "here", {"a": np.arange(2), "b": np.ones(3)}, 7, 1)
    assert contents == {(tmp_path / "here").read_bytes()}


def damage_cases() -> list[tuple[str, bytes]]:
    return [("empty", b""), ("text", b"not a checkpoint, just a sentence"), ("huge header", b"\xff" * 64)]


@pytest.mark.parametrize("damage", [case for _, case in damage_cases()], ids=[name for name, _ in damage_cases()])
def test_a_damaged_one_is_named_with_its_mend(run: RunFolder, damage: bytes) -> None:
    run.save_checkpoint(ARRAYS, iteration=20, chunks=2)
    (run.path / "checkpoint" / "state.safetensors").write_bytes(damage)
    with pytest.raises(InputError, match=r"state.safetensors: is damaged.*gsiirl resume") as error:
        run.load_checkpoint()
    assert "\n" not in str(error.value)


def test_a_cut_off_one_is_named(run: RunFolder) -> None:
    run.save_checkpoint(ARRAYS, iteration=20, chunks=2)
    path = run.path / "checkpoint" / "state.safetensors"
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(InputError, match="is damaged"):
        run.load_checkpoint()


@pytest.mark.parametrize(
    ("old", "new"),
    [(b'"format_version":"1"', b'"format_version":"2"'), (b'"iteration":"20"', b'"iteration":"2x"')],
)
def test_wrong_metadata_is_refused(tmp_path: Path, old: bytes, new: bytes) -> None:
    path = tmp_path / "state.safetensors"
    write_checkpoint(path, {"state": np.zeros(2)}, iteration=20, chunks=2)
    assert old in path.read_bytes()
    path.write_bytes(resealed(path.read_bytes().replace(old, new)))
    with pytest.raises(InputError, match="is damaged"):
        read_checkpoint(path)
