"""A file that is not as it was written is known by the checksum in it."""

import random
import warnings
from pathlib import Path

import numpy as np
import polars
import pytest
from report.synthetic import RING, SyntheticGame, write_run
from resealing import CARRIED

from gsiirl.errors import InputError, InputWarning
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs import RunFolder
from gsiirl.runs.files.array_file import read_arrays, write_arrays
from gsiirl.runs.files.checksum import PLACE, is_intact
from gsiirl.runs.files.json_file import read_json, write_json
from gsiirl.runs.files.table_file import read_table, write_table

FILES = (
    "config.json",
    "game.json",
    "summary.json",
    "learned.json",
    "learned.safetensors",
    "policies.safetensors",
    "environment.json",
    "paths.parquet",
    "metrics/chunk-00000.parquet",
    "checkpoint/state.safetensors",
)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = write_run(tmp_path_factory.mktemp("runs") / "run", "gsiirl", SyntheticGame(RING), seeds=2, iterations=2)
    folder.save_policies({"learner.table": np.full((2, 3), 0.5)})
    folder.save_checkpoint({"state": np.arange(9.0)}, iteration=2, chunks=1)
    return folder.path


def read_all(folder: Path) -> None:
    ReportedRun.read(folder)
    run = RunFolder.open(folder)
    run.load_policies()
    run.load_checkpoint()


def test_every_file_of_a_run_carries_one(run: Path) -> None:
    files = [path for path in run.rglob("*") if path.is_file()]
    assert {str(path.relative_to(run)) for path in files} == {*FILES}
    assert all(is_intact(path.read_bytes()) for path in files)
    read_all(run)


@pytest.mark.parametrize("name", FILES)
def test_one_flipped_bit_anywhere_is_damage(run: Path, name: str) -> None:
    path = run / name
    content = path.read_bytes()
    for bit in random.Random(name).sample(range(8 * len(content)), 12):
        damaged = bytearray(content)
        damaged[bit // 8] ^= 1 << bit % 8
        path.write_bytes(damaged)
        with pytest.raises(InputError, match="is damaged"):
            read_all(run)
    path.write_bytes(content)


@pytest.mark.parametrize("name", FILES)
def test_a_file_without_one_does_not_belong_to_a_run_that_has_them(run: Path, name: str) -> None:
    path = run / name
    content = path.read_bytes()
    path.write_bytes(CARRIED.sub(b"gsiirl-shb256:" + 64 * b"0", content))
    with pytest.raises(InputError, match="is damaged: its checksum is gone"):
        read_all(run)
    path.write_bytes(content)


def test_files_of_earlier_versions_are_read_and_that_is_said_once(run: Path, tmp_path: Path) -> None:
    old = tmp_path / "old"
    for name in FILES:
        (old / name).parent.mkdir(parents=True, exist_ok=True)
        content = (run / name).read_bytes()
        (old / name).write_bytes(CARRIED.sub(len(PLACE) * b"x", content.replace(b'"checksum"', b'"nothing1"')))
    with pytest.warns(InputWarning, match="old was written before files carried checksums") as said:
        read_all(old)
    assert len({str(each.message) for each in said}) == 1
    # What is written from now on is checked there too.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        RunFolder.open(old).save_checkpoint({"state": np.ones(3)}, iteration=2, chunks=1)
        path = old / "checkpoint" / "state.safetensors"
        path.write_bytes(path.read_bytes()[:-1] + b"\x01")
        with pytest.raises(InputError, match="is not what its checksum says"):
            RunFolder.open(old).load_checkpoint()


def test_what_looks_like_one_in_a_users_text_does_not_disturb(tmp_path: Path) -> None:
    for text in (PLACE, PLACE.replace("0", "a")):
        write_json(tmp_path / "a.json", {"name": text})
        assert read_json(tmp_path / "a.json", "", carries=True)["name"] == text
        write_arrays(tmp_path / "a.safetensors", {text: np.zeros(2)}, {"zzz": text})
        assert list(read_arrays(tmp_path / "a.safetensors", "", carries=True)[0]) == [text]


def test_the_same_content_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_table(tmp_path / name, {"x": np.arange(3)}, {"x": polars.Int64})
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert read_table(tmp_path / "a", "", carries=True)["x"].to_list() == [0, 1, 2]
