"""Compiled programs are kept between commands, and change no figure."""

import os
import platform
import subprocess
import sys
import warnings
from pathlib import Path

import platformdirs
import pytest
from filelock import FileLock

from gsiirl import program_cache, scenarios
from gsiirl.cli import main

NAMES = (
    "JAX_COMPILATION_CACHE_DIR",
    "JAX_ENABLE_COMPILATION_CACHE",
    "JAX_COMPILATION_CACHE_MAX_SIZE",
    "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS",
)


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user without settings of JAX, whose cache folder is empty."""
    for name in NAMES:
        # Set first, so that what the test sets is taken back.
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / name)
    return tmp_path


def test_programs_are_kept_in_a_folder_of_this_processor_and_of_bounded_size(elsewhere: Path) -> None:
    program_cache.keep_programs()
    folder = Path(os.environ["JAX_COMPILATION_CACHE_DIR"])
    assert folder.is_dir()
    assert folder.is_relative_to(elsewhere)
    assert folder.name.endswith(program_cache.processor())
    assert int(os.environ["JAX_COMPILATION_CACHE_MAX_SIZE"]) == program_cache.LARGEST


def test_another_processor_has_another_folder(elsewhere: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here = program_cache.program_folder()
    assert program_cache.program_folder() == here
    monkeypatch.setattr(platform, "processor", lambda: "another one")
    assert program_cache.program_folder() != here


@pytest.mark.parametrize("name", NAMES[:2])
def test_what_the_user_sets_holds(elsewhere: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setenv(name, "false")
    program_cache.keep_programs()
    assert os.environ[name] == "false"
    assert not any(other in os.environ for other in NAMES if other != name)


def test_where_no_folder_can_be_made_nothing_is_kept(elsewhere: Path) -> None:
    (elsewhere / "gsiirl").write_text("a file")
    program_cache.keep_programs()
    assert not any(name in os.environ for name in NAMES)


def test_a_program_that_a_killed_process_left_half_written_is_removed(elsewhere: Path) -> None:
    folder = program_cache.program_folder()
    folder.mkdir(parents=True)
    for name in ("whole-cache", "whole-atime", "half-cache", "alone-atime"):
        (folder / name).write_text("")
    with FileLock(folder / ".lockfile"):
        program_cache.keep_programs()
        # Perhaps it is being written just now.
        assert (folder / "half-cache").exists()
    del os.environ["JAX_COMPILATION_CACHE_DIR"]
    program_cache.keep_programs()
    assert {path.name for path in folder.iterdir()} == {"whole-cache", "whole-atime", "alone-atime", ".lockfile"}


def test_a_program_that_cannot_be_kept_is_no_matter(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def warn() -> None:
        for doing in ("reading", "writing"):
            warnings.warn(f"Error {doing} persistent compilation cache entry for 'jit_f': OSError: full", stacklevel=1)
        warnings.warn("something else", stacklevel=1)

    monkeypatch.setattr(scenarios, "known_scenarios", lambda: warn() or ["none"])
    with pytest.warns(UserWarning, match="something else"):
        assert main(["list"]) == 0
    assert "persistent" not in capsys.readouterr().err


@pytest.mark.slow
def test_neither_kept_nor_damaged_programs_change_a_byte(tmp_path: Path) -> None:
    settings = {name: value for name, value in os.environ.items() if name not in NAMES}
    settings["XDG_CACHE_HOME"] = str(tmp_path / "cache")

    def run(name: str, **more: str) -> dict[str, bytes]:
        command = [
            "run",
            "security",
            "--graph=small-linear",
            "--algorithm=marl",
            "--seeds=1",
            f"--out={tmp_path / name}",
        ]
        ran = subprocess.run(
            [sys.executable, "-m", "gsiirl", *command], env=settings | more, check=True, capture_output=True, text=True
        )
        assert ran.stderr == ""
        found = {str(path.relative_to(tmp_path / name)): path for path in (tmp_path / name).rglob("*")}
        return {name: path.read_bytes() for name, path in found.items() if path.is_file() and "environment" not in name}

    expected = run("without", JAX_ENABLE_COMPILATION_CACHE="false")
    assert not (tmp_path / "cache").exists()
    assert run("cold") == expected
    kept = list((tmp_path / "cache").rglob("*-cache"))
    assert kept
    assert run("warm") == expected
    for number, path in enumerate(kept):
        # Cut short, as by a full disk, or something else altogether.
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2] if number % 2 else b"not a program")
    assert run("damaged") == expected
