"""How a run was made is told without a path of the machine."""

import os
from pathlib import Path

import pytest
from report.made_up import made_up_run
from report.synthetic import write_run

from gsiirl.report.read.made import Made
from gsiirl.report.read.run import ReportedRun


def made(folder: Path, config: dict) -> Made:
    return ReportedRun.read(made_up_run(folder / "mine", "gsiirl", [-4.6] * 4, config=config)).made


@pytest.mark.parametrize("path", ["/home/me/my nets/office.json", r"C:\Users\me\my nets\office.json"])
def test_the_command_has_every_setting_and_no_path(tmp_path: Path, path: str) -> None:
    config = {"graph": path, "graph_seed": 0, "nodes": 8, "expert_no_op": True, "learner_no_op": False, "solver": None}
    found = made(tmp_path, config)
    assert found.command == (
        "gsiirl run security --algorithm gsiirl --graph office.json --expert-no-op --no-learner-no-op --out mine"
    )
    assert found.settings == {
        "algorithm": "gsiirl",
        "graph": "office.json",
        "expert_no_op": "yes",
        "learner_no_op": "no",
    }
    assert "me" not in str(found).replace("settings", "")


def test_ones_own_game_is_named_by_its_file(tmp_path: Path) -> None:
    assert made(tmp_path, {"file": "/home/me/mine.py:game"}).command.startswith(
        "gsiirl run security mine.py:game --alg"
    )


def test_seeds_version_and_date_are_those_of_the_run(tmp_path: Path) -> None:
    found = ReportedRun.read(write_run(tmp_path / "run", "gsiirl").path).made
    assert (found.version, found.date, found.seeds) == ("0.1.0", "2026-01-31", "0 to 2")


def test_a_run_that_has_not_ended_has_the_date_of_its_metrics(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", "gsiirl", completed=False)
    (run.path / "environment.json").unlink()
    (chunk,) = (run.path / "metrics").iterdir()
    os.utime(chunk, (86_400 * 365.25, 86_400 * 365.25))
    found = ReportedRun.read(run.path).made
    assert (found.version, found.date) == ("not recorded", "1971-01-01")
