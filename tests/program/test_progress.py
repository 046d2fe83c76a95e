"""Off a terminal progress is told in lines: at first, at whatever is new, and now and then."""

import threading
import time

import pytest
from rich.console import Console

from gsiirl.program import progress
from gsiirl.program.progress import Begun, shown


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, seconds in (("FIRST", 0.02), ("GLANCE", 0.01), ("EVERY", 0.2)):
        monkeypatch.setattr(progress, name, seconds)


def some_steps(quiet: bool = False, of: int = 3) -> None:
    with shown(quiet) as bars:
        run = Begun(bars, "a run")
        for done in (0, 0, of):
            time.sleep(0.06)
            run.tell(done, of)
        time.sleep(0.06)


def test_every_new_step_is_a_line(capsys: pytest.CaptureFixture[str]):
    some_steps()
    assert capsys.readouterr().out.splitlines() == [
        "a run: preparing (0:00:00)",
        "a run: compiling 0 of 3 (0:00:00)",
        "a run 0 of 3 (0:00:00)",
        "a run: ending 3 of 3 (0:00:00)",
    ]


def test_nothing_is_counted_where_there_is_nothing_to_count(capsys: pytest.CaptureFixture[str]):
    some_steps(of=0)
    assert "of 0" not in capsys.readouterr().out


def test_a_step_that_lasts_is_told_again(capsys: pytest.CaptureFixture[str]):
    with shown() as bars:
        Begun(bars, "a run")
        time.sleep(0.5)
    lines = capsys.readouterr().out.splitlines()
    assert lines == ["a run: preparing (0:00:00)"] * len(lines)
    assert 2 <= len(lines) <= 3


def test_in_quiet_nothing_is_told(capsys: pytest.CaptureFixture[str]):
    some_steps(quiet=True)
    assert capsys.readouterr() == ("", "")


def test_what_is_refused_at_once_has_no_line(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(progress, "FIRST", 5.0)
    began = time.monotonic()
    with shown() as bars:
        Begun(bars, "a run")
    assert time.monotonic() - began < 1
    assert capsys.readouterr() == ("", "")


def test_what_is_over_is_told_no_more(capsys: pytest.CaptureFixture[str]):
    with shown() as bars:
        first, _ = Begun(bars, "first"), Begun(bars, "second")
        time.sleep(0.06)
        first.end()
        time.sleep(0.06)
    assert capsys.readouterr().out.splitlines() == [
        "first: preparing (0:00:00); second: preparing (0:00:00)",
        "second: preparing (0:00:00)",
    ]


def test_a_log_on_a_full_disk_stops_nothing(monkeypatch: pytest.MonkeyPatch):
    failed = list[BaseException]()
    monkeypatch.setattr(threading, "excepthook", lambda told: failed.append(told.exc_value))

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Console, "print", full)
    some_steps()
    assert not failed
