"""A crash while writing leaves the old file whole."""

import os
from pathlib import Path

import numpy as np
import pytest

from gsiirl.runs import RunFolder
from gsiirl.runs.files.atomic import write_atomically

CONFIG = {"experiment": "security", "algorithm": "gsiirl"}


def crash(*arguments: object) -> None:
    raise OSError("no space left")


def test_a_crash_keeps_the_old_content_and_leaves_nothing_aside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_atomically(tmp_path / "file", b"old")
    monkeypatch.setattr(os, "replace", crash)
    with pytest.raises(OSError, match="no space left"):
        write_atomically(tmp_path / "file", b"new")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("file", b"old")]


def test_what_a_killed_process_left_aside_does_not_disturb(tmp_path: Path) -> None:
    run = RunFolder.create(tmp_path / "run", CONFIG, {})
    run.append_metrics(0, {"seed": np.array([0]), "iteration": np.array([0])})
    (run.path / "metrics" / "chunk-00001.parquet.aside").write_bytes(b"half")
    assert len(run.metrics()) == 1
    run.append_metrics(1, {"seed": np.array([0]), "iteration": np.array([1])})
    assert sorted(path.name for path in (run.path / "metrics").iterdir()) == [
        "chunk-00000.parquet",
        "chunk-00001.parquet",
    ]


def test_a_crash_keeps_the_old_checkpoint_and_the_old_metrics(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = RunFolder.create(tmp_path / "run", CONFIG, {})
    run.save_checkpoint({"state": np.zeros(3)}, iteration=1, chunks=1)
    run.append_metrics(0, {"seed": np.array([0]), "iteration": np.array([0])})
    with monkeypatch.context() as crashing:
        crashing.setattr(os, "replace", crash)
        with pytest.raises(OSError, match="no space left"):
            run.save_checkpoint({"state": np.ones(3)}, iteration=2, chunks=2)
        with pytest.raises(OSError, match="no space left"):
            run.append_metrics(0, {"seed": np.array([7]), "iteration": np.array([7])})
    checkpoint = run.load_checkpoint()
    assert checkpoint is not None
    assert checkpoint.iteration == 1
    np.testing.assert_array_equal(checkpoint.arrays["state"], np.zeros(3))
    assert run.metrics()["seed"].to_list() == [0]
