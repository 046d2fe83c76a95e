"""A run folder can be made, opened and refused."""

import errno
import json
import os
from dataclasses import replace
from pathlib import Path

import pytest
from resealing import rewrite

from gsiirl.errors import InputError
from gsiirl.runs import Environment, RunFolder, Statistics, Summary
from gsiirl.runs.files.json_file import write_json

CONFIG = {"format_version": 1, "experiment": "security", "algorithm": "gsiirl", "seeds": 3, "temperature": 0.1 + 0.2}
GAME = {"format_version": 1, "kind": "attack_graph", "name": "tiny", "variant": "general_sum", "horizon": 10}


def content_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def unseal(folder: Path) -> None:
    """Make the JSON files of a run folder those of an earlier version, without checksums."""
    for path in folder.glob("*.json"):
        content = json.loads(path.read_text())
        path.write_text(json.dumps({name: value for name, value in content.items() if name != "checksum"}))


def summary_of(nash_gap: float) -> Summary:
    return Summary(
        "security", "gsiirl", [0], [], 3, completed=True, final={"nash_gap": Statistics(nash_gap, 0.0, [1.0])}
    )


def one_line(error: pytest.ExceptionInfo[InputError]) -> str:
    text = str(error.value)
    assert "\n" not in text
    return text


def test_a_new_run_reads_back_as_it_was_written(tmp_path: Path) -> None:
    made = RunFolder.create(tmp_path / "deep" / "run", CONFIG, GAME)
    assert RunFolder.open(tmp_path / "deep" / "run") == made
    assert made.config == CONFIG
    assert made.game == GAME


def test_json_keeps_key_order_and_exact_floats_and_ends_with_a_newline(tmp_path: Path) -> None:
    RunFolder.create(tmp_path / "run", CONFIG, GAME)
    text = (tmp_path / "run" / "config.json").read_text()
    assert text.index("experiment") < text.index("algorithm") < text.index("seeds")
    assert "0.30000000000000004" in text
    assert text.endswith("}\n")


def test_format_version_is_added_where_the_caller_left_it_out(tmp_path: Path) -> None:
    config = {key: value for key, value in CONFIG.items() if key != "format_version"}
    assert RunFolder.create(tmp_path / "run", config, GAME).config == CONFIG


def test_an_empty_folder_may_be_used(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    RunFolder.create(tmp_path / "run", CONFIG, GAME)
    assert RunFolder.is_at(tmp_path / "run")


@pytest.mark.parametrize(
    ("config", "game", "problem"),
    [
        (CONFIG, GAME, "holds this run already; use gsiirl resume"),
        ({**CONFIG, "seeds": 4}, GAME, "holds another run"),
        (CONFIG, {**GAME, "name": "other"}, "holds another run"),
    ],
)
def test_a_folder_with_a_run_is_refused_and_left_alone(tmp_path: Path, config: dict, game: dict, problem: str) -> None:
    RunFolder.create(tmp_path / "run", CONFIG, GAME)
    before = content_of(tmp_path)
    with pytest.raises(InputError) as error:
        RunFolder.create(tmp_path / "run", config, game)
    assert error.value.field == "--out"
    assert problem in one_line(error)
    assert content_of(tmp_path) == before


def test_the_same_run_is_known_through_tuples(tmp_path: Path) -> None:
    RunFolder.create(tmp_path / "run", {**CONFIG, "sizes": (1, 2)}, GAME)
    with pytest.raises(InputError, match="holds this run already"):
        RunFolder.create(tmp_path / "run", {**CONFIG, "sizes": (1, 2)}, GAME)


@pytest.mark.parametrize("name", ["notes.txt", "config.json", "game.json"])
def test_a_folder_with_other_files_is_refused_and_left_alone(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    with pytest.raises(InputError) as error:
        RunFolder.create(tmp_path, CONFIG, GAME)
    assert "holds other files" in one_line(error)
    assert content_of(tmp_path) == {name: b"mine"}


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run").write_text("mine")
    for path in (tmp_path / "run", tmp_path / "run" / "below"):
        with pytest.raises(InputError) as error:
            RunFolder.create(path, CONFIG, GAME)
        assert error.value.field == "--out"
        one_line(error)
    assert content_of(tmp_path) == {"run": b"mine"}


def test_nan_in_a_description_is_an_error_and_makes_no_folder(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"game.json: nodes\[1\].value is nan"):
        RunFolder.create(tmp_path / "run", CONFIG, {**GAME, "nodes": [{"value": 1.0}, {"value": float("nan")}]})
    assert not (tmp_path / "run").exists()


def test_opening_what_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is no folder"):
        RunFolder.open(tmp_path / "absent")
    with pytest.raises(InputError, match="is no run folder"):
        RunFolder.open(tmp_path)


@pytest.mark.parametrize("name", ["config.json", "game.json"])
@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("{", "no valid JSON"),
        (100_000 * "[", "no valid JSON"),
        ('{"format_version": 1, "value": NaN}', "no valid JSON"),
        ('{"format_version": 1, "value": 1e999}', "value is no number of a sensible size"),
        ('{"format_version": 1, "value": [1e101]}', "value[0] is no number of a sensible size"),
        ('{"format_version": 1, "value": "\\ud800"}', "no valid JSON"),
        ("[1]", "no JSON object"),
        ('{"format_version": 99}', "unknown format_version 99"),
        ("{}", "names no format_version"),
        (b"\xff\xfe", "no valid JSON"),
    ],
)
def test_a_damaged_description_of_an_earlier_version_is_named(
    tmp_path: Path, name: str, content: str | bytes, problem: str
) -> None:
    RunFolder.create(tmp_path / "run", CONFIG, GAME)
    unseal(tmp_path / "run")
    (tmp_path / "run" / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError) as error:
        RunFolder.open(tmp_path / "run")
    assert name in error.value.field
    assert problem in one_line(error)


def test_a_config_without_an_algorithm_is_damaged(tmp_path: Path) -> None:
    RunFolder.create(tmp_path / "run", CONFIG, GAME)
    rewrite(tmp_path / "run" / "config.json", '"algorithm"', '"method"')
    with pytest.raises(InputError, match="names no algorithm"):
        RunFolder.open(tmp_path / "run")


def test_summary_and_environment_read_back_and_are_none_before(tmp_path: Path) -> None:
    run = RunFolder.create(tmp_path / "run", CONFIG, GAME)
    assert run.summary() is None
    assert run.environment() is None
    run.write_summary(summary_of(1.0))
    run.write_environment(Environment(wall_seconds=1.5))
    assert run.summary() == summary_of(1.0)
    assert run.environment() == Environment(wall_seconds=1.5)


def test_nan_in_a_summary_is_an_error_and_keeps_the_old_one(tmp_path: Path) -> None:
    run = RunFolder.create(tmp_path / "run", CONFIG, GAME)
    run.write_summary(summary_of(1.0))
    with pytest.raises(ValueError, match=r"summary.json: final.nash_gap.mean is inf"):
        run.write_summary(summary_of(float("inf")))
    assert run.summary() == summary_of(1.0)


LEFT = ["game.json", "game.json.aside", "config.json.aside", ".lock"]


def test_what_a_run_left_before_it_had_begun_is_cleared(tmp_path: Path) -> None:
    for left in (LEFT[:1], LEFT[1:2], LEFT[:3], LEFT[3:], LEFT):
        for name in left:
            write_json(tmp_path / name, {**GAME, "name": "other"})
        assert RunFolder.is_free(tmp_path)
        run = RunFolder.create(tmp_path, CONFIG, GAME)
        assert {path.name for path in tmp_path.iterdir()} - {".lock"} == {"config.json", "game.json"}
        assert RunFolder.open(tmp_path) == run
        for path in tmp_path.iterdir():
            path.unlink()


@pytest.mark.parametrize("others", [{"notes.txt": "mine"}, {"game.json": "{}"}, {"game.json": "no JSON"}])
def test_what_may_be_a_users_is_left_alone(tmp_path: Path, others: dict[str, str]) -> None:
    for name in LEFT:
        write_json(tmp_path / name, GAME)
    for name, text in others.items():
        (tmp_path / name).write_text(text)
    before = content_of(tmp_path)
    with pytest.raises(InputError, match="holds other files; use a new or empty folder"):
        RunFolder.create(tmp_path, CONFIG, GAME)
    assert content_of(tmp_path) == before


@pytest.mark.parametrize("written", [0, 1])
@pytest.mark.parametrize("there", [False, True])
def test_a_disk_that_is_full_at_first_leaves_nothing_and_the_same_run_begins_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: int, there: bool
) -> None:
    folder, calls = tmp_path / "run", list[int]()
    if there:
        folder.mkdir()

    def full(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) > written:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as disk:
        disk.setattr(os, "fsync", full)
        with pytest.raises(InputError) as error:
            RunFolder.create(folder, CONFIG, GAME)
    assert (
        one_line(error)
        == f"--out: {folder} cannot be written (No space left on device); make room or allow it, or use another folder"
    )
    assert folder.exists() == there
    assert content_of(tmp_path) == {}
    RunFolder.create(folder, CONFIG, GAME)


def test_names_that_no_file_system_takes_are_told() -> None:
    path = Path("x" * 300)
    with pytest.raises(InputError, match=r"cannot be read \(File name too long\); give the --out folder of a run"):
        RunFolder.open(path)
    with pytest.raises(InputError, match=r"^--out: .* cannot be read \(File name too long\); use another folder"):
        RunFolder.create(path, CONFIG, GAME)


SOUND = Summary("security", "gsiirl", [3, 4, 5], [4], 2, True, {"nash_gap": Statistics(1.5, 0.7, [1.0, 2.0])})


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('"completed"', '"ended"', "completed: Field required"),
        ('"completed": true', '"completed": 1', "completed: Input should be a valid boolean"),
        ('"iterations": 2', '"iterations": 2.5', "iterations: Input should be a valid integer"),
        ('"iterations": 2', '"iterations": -2', "iterations cannot be -2"),
        ('"iterations": 2', '"iterations": "2"', "iterations: Input should be a valid integer"),
        ('"mean": 1.5', '"mean": null', "final.nash_gap.mean: Input should be a valid number"),
        ('"mean": 1.5', '"mean": 1e999', "final.nash_gap.mean is no number of a sensible size"),
        ('"mean": 1.5', '"mean": NaN', "no valid JSON"),
        ("1.0,", "", "final.nash_gap holds 1 values of 2 seeds"),
        ('"security"', '"crossing"', "it is of another run"),
        ("3,", "9,", "seeds are not in ascending order"),
        ("3,", "4,", "seeds are not in ascending order"),
        ("5\n", "9999999999999999999\n", "seeds are not in ascending order"),
        ('"files": []', '"files": ["learned.json"]', "learned.json: is missing"),
        ('"files": []', '"files": ["../../secret"]', "names files that no run writes"),
    ],
)
def test_a_summary_that_cannot_be_is_named(tmp_path: Path, old: str, new: str, problem: str) -> None:
    run = RunFolder.create(tmp_path / "run", CONFIG, GAME)
    run.write_summary(SOUND)
    assert run.summary() == SOUND
    rewrite(run.path / "summary.json", old, new)
    with pytest.raises(InputError) as error:
        run.summary()
    assert problem in one_line(error)


def test_a_seed_that_fails_must_be_one(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="failed_seeds names a seed that is none"):
        replace(SOUND, failed_seeds=[7])


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('"wall_seconds": 1.5', '"wall_seconds": "long"', "wall_seconds: Input should be a valid number"),
        ('"wall_seconds": 1.5', '"wall_seconds": -1', "wall_seconds is below 0"),
        ('"wall_seconds": 1.5', '"wall_seconds": 1e200', "wall_seconds is no number of a sensible size"),
        ('"packages": {}', '"packages": []', "packages: Input should be an object"),
    ],
)
def test_an_environment_that_cannot_be_is_named(tmp_path: Path, old: str, new: str, problem: str) -> None:
    run = RunFolder.create(tmp_path / "run", CONFIG, GAME)
    run.write_environment(Environment(wall_seconds=1.5))
    rewrite(run.path / "environment.json", old, new)
    with pytest.raises(InputError, match=problem):
        run.environment()
