"""Which run folders a user means."""

from pathlib import Path

import pytest

from gsiirl.errors import InputError
from gsiirl.finished.folders import run_folders


def made(*folders: Path) -> list[Path]:
    """Folders with the one file by which a run is known."""
    for folder in folders:
        folder.mkdir(parents=True)
        (folder / "config.json").write_text("{}")
    return list(folders)


def test_a_run_is_itself_and_nothing_below_it(tmp_path: Path) -> None:
    outer, _ = made(tmp_path / "run", tmp_path / "run/copy")
    assert run_folders([outer]) == [outer]


def test_of_a_folder_of_runs_those_directly_below_in_order_and_each_once(tmp_path: Path) -> None:
    second, first, _ = made(tmp_path / "b", tmp_path / "a", tmp_path / "old/c")
    (tmp_path / "notes.txt").write_text("")
    assert run_folders([tmp_path, second]) == [first, second]


def test_of_a_folder_of_folders_of_runs_those_two_levels_down(tmp_path: Path) -> None:
    runs = made(tmp_path / "crossing/gsiirl", tmp_path / "crossing/marl", tmp_path / "deception/gsiirl")
    (tmp_path / "report").mkdir()
    (tmp_path / "report/index.html").write_text("")
    assert run_folders([tmp_path]) == runs


def test_a_folder_without_runs_is_named(tmp_path: Path) -> None:
    made(tmp_path / "too/far/down")
    with pytest.raises(InputError, match="neither is nor holds a run folder"):
        run_folders([tmp_path])
