"""A short run of the fuzzer of run folders."""

import random
import re
from pathlib import Path

import pytest
from fuzz import fuzz_run_folder
from fuzz.fuzz_run_folder import fuzz
from resealing import resealed

from gsiirl.errors import InputError
from gsiirl.runs.files import json_file


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::gsiirl.errors.InputWarning")  # of folders without checksums
@pytest.mark.parametrize(("kind", "inputs"), [("json", 2000), ("binary", 1000), ("earlier", 20)])
def test_damaged_run_folders_are_refused_in_one_line(kind: str, inputs: int, tmp_path: Path):
    counts = fuzz(kind, inputs, 0, tmp_path)
    assert sum(counts.values()) == inputs
    assert {name.split()[-1] for name in counts} >= {"refused"}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::gsiirl.errors.InputWarning")
def test_a_planted_fault_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    # The words of a refusal are cut at a place that short ones do not have.
    monkeypatch.setattr(json_file, "_short", lambda text: text[200])
    with pytest.raises(AssertionError, match=r"input .* of seed 0"):
        fuzz("json", 2000, 0, tmp_path)


def test_damage_is_the_same_for_the_same_seed():
    content = b'{"checksum": "x", "a": [1, 2.5, {"b": null}]}'
    assert len({fuzz_run_folder.damaged_json(content, random.Random(1)) for _ in range(5)}) == 1


@pytest.mark.parametrize(("kind", "name"), [("game", "game.json"), ("saved", "result.json")])
def test_a_horizon_of_any_number_is_refused_at_once(kind: str, name: str, tmp_path: Path):
    fuzz_run_folder.make_game(tmp_path)
    path = tmp_path / kind / name
    path.write_bytes(resealed(re.sub(rb'"horizon": 3', b'"horizon": ' + b"9" * 12, path.read_bytes())))
    with pytest.raises(InputError, match="not of 999999999999 steps"):
        fuzz_run_folder.read_result(tmp_path / kind)


def test_a_file_that_no_run_writes_is_not_repeated_in_the_line(tmp_path: Path):
    fuzz_run_folder.make_played(tmp_path / "played")
    path = tmp_path / "played" / "summary.json"
    path.write_bytes(resealed(path.read_bytes().replace(b'"policies.safetensors"', b'"p\\u0007licies.safetensors"')))
    with pytest.raises(InputError, match=r"summary\.json: is damaged: it names files that no run writes"):
        fuzz_run_folder.read_played(tmp_path / "played")
