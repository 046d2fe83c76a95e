"""One process works in a run folder; the kernel forgets it when it ends, however that ends."""

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from gsiirl.errors import InputError
from gsiirl.runs import RunFolder, lock, locked

HOLD = """
import sys, time, pathlib
from gsiirl.runs import locked
with locked(pathlib.Path(sys.argv[1]), ""):
    print(flush=True)
    time.sleep(60)
"""


@contextmanager
def another_process(folder: Path) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen([sys.executable, "-c", HOLD, str(folder)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield process
        finally:
            process.kill()


def test_a_second_process_is_refused_and_a_killed_one_forgotten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(lock, "PATIENCE", 0.1)
    folder = tmp_path / "deep" / "run"
    with another_process(folder) as process:
        with (
            pytest.raises(InputError, match=r"^--out: .*run is in use by another process; wait until it has ended$"),
            locked(folder, "--out"),
        ):
            pass
        # A folder is named once.
        with pytest.raises(InputError) as refused, locked(folder, str(folder)):
            pass
        assert str(refused.value) == f"{folder}: is in use by another process; wait until it has ended"
        process.kill()
        process.wait()
    assert [path.name for path in folder.iterdir()] == [lock.LOCK]
    with locked(folder, "--out"):
        pass
    assert list(folder.iterdir()) == []


def test_one_that_is_about_to_end_is_waited_for(tmp_path: Path):
    with another_process(tmp_path) as process:
        threading.Timer(0.2, process.kill).start()
        with locked(tmp_path, "--out"):
            assert process.poll() is not None or process.wait(1)


def test_a_folder_that_was_made_for_it_goes_with_it_where_nothing_came_to_be_there(tmp_path: Path):
    with locked(tmp_path / "run", "--out"):
        assert RunFolder.is_free(tmp_path / "run")
    assert list(tmp_path.iterdir()) == []
    with locked(tmp_path / "run", "--out"):
        RunFolder.create(tmp_path / "run", {"experiment": "security", "algorithm": "gsiirl"}, {})
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == ["config.json", "game.json"]


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path):
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(InputError, match=r"^--out: .*run cannot be written \(Not a directory\); use another folder$"),
        locked(tmp_path / "file" / "run", "--out"),
    ):
        pass
