import multiprocessing
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from problems import tiny_config

from gsiirl.errors import InputError
from gsiirl.experiments import runner
from gsiirl.experiments.config import config_to_dict
from gsiirl.experiments.plans import side_by_side
from gsiirl.experiments.plans.plan import carry_out, check_folders, failed_seeds, refuse_failures
from gsiirl.experiments.plans.planned_run import PlannedRun
from gsiirl.experiments.plans.worker import Worker
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.runs import RunFolder, Summary
from gsiirl.runs.files.json_file import write_json


@pytest.fixture
def done(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, Path]]:
    """What a stand-in of the runner was asked to do, in order; each run gets what makes its folder a run folder."""
    calls: list[tuple[str, Path]] = []

    def run(config: SecurityConfig, folder: Path, _: object) -> None:
        RunFolder.create(folder, config_to_dict(config.resolved()), {"name": "none"})
        calls.append(("run", folder))

    monkeypatch.setattr(runner, "run", run)
    monkeypatch.setattr(runner, "resume", lambda folder, _: calls.append(("resume", folder)))
    return calls


def planned(folder: Path) -> list[PlannedRun]:
    return [PlannedRun(folder / name, tiny_config(algorithm=name)) for name in ("marl", "ma-irl")]


def test_what_is_there_is_gone_on_with_and_the_rest_begun(done, tmp_path):
    first, second = planned(tmp_path)
    carry_out([first])
    carry_out([first, second])
    assert done == [("run", first.folder), ("resume", first.folder), ("run", second.folder)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_is_finished_is_left_alone(done, tmp_path, monkeypatch, jobs: int):
    [each, _] = planned(tmp_path)
    folder = RunFolder.create(each.folder, config_to_dict(each.config.resolved()), {"name": "none"})
    folder.write_summary(Summary("security", "marl", [0, 1], [], 2, completed=True, final={}))

    def no_process(*_: object, **__: object) -> None:
        raise AssertionError("a process was started for a run that is finished")

    monkeypatch.setattr(multiprocessing.get_context("spawn"), "Process", no_process)
    carry_out([each], jobs)
    assert done == []


@pytest.mark.parametrize("left", [[], ["game.json.aside"], ["game.json", "config.json.aside"]])
def test_a_folder_cut_before_it_was_a_run_is_begun_anew(done, tmp_path, left: list[str]):
    [each, _] = planned(tmp_path)
    each.folder.mkdir()
    for name in left:
        write_json(each.folder / name, {"format_version": 1})
    carry_out([each])
    assert done == [("run", each.folder)]
    assert not list(each.folder.glob("*.aside"))


def test_nothing_is_begun_when_any_folder_is_not_free(done, tmp_path):
    runs = planned(tmp_path)
    last = runs[-1].folder
    RunFolder.create(last, config_to_dict(tiny_config(seeds=7).resolved()), {"name": "none"})
    with pytest.raises(InputError, match="ma-irl holds a run with other settings; use another folder"):
        carry_out(runs)
    (last / "config.json").write_text("{")
    with pytest.raises(InputError, match=r"config\.json: is damaged"):
        carry_out(runs)
    (last / "config.json").unlink()
    (last / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="ma-irl holds other files"):
        carry_out(runs)
    assert (last / "notes.txt").read_text() == "mine"
    for path in last.iterdir():
        path.unlink()
    last.rmdir()
    last.write_text("mine")
    with pytest.raises(InputError, match="ma-irl is a file"):
        carry_out(runs)
    with pytest.raises(InputError, match="ma-irl is a file"):
        check_folders(planned(last))
    assert done == []


def test_a_plan_does_not_go_into_a_run(done, tmp_path):
    RunFolder.create(tmp_path, config_to_dict(tiny_config().resolved()), {"name": "none"})
    with pytest.raises(InputError, match="holds a run; use another folder"):
        carry_out(planned(tmp_path / "deep" / "in"))
    assert done == []


def test_a_configuration_that_cannot_be_used_stops_the_plan_before_it_begins(done, tmp_path):
    good, _ = planned(tmp_path)
    bad = PlannedRun(tmp_path / "bad", tiny_config(commitment="reward", solver="q_learning", hypergradient="implicit"))
    with pytest.raises(InputError, match="q_learning cannot be differentiated"):
        carry_out([good, bad])
    assert done == []


def test_failed_seeds_are_named_by_run(done, tmp_path):
    runs = planned(tmp_path)
    carry_out(runs)
    for (folder, config), failed in zip(runs, ([], [3, 5]), strict=True):
        summary = Summary("security", config.algorithm, [3, 4, 5], failed, 2, completed=True, final={})
        RunFolder.open(folder).write_summary(summary)
    assert failed_seeds(runs) == {runs[1].folder: [3, 5]}


@pytest.mark.parametrize(
    ("cores", "jobs", "expected"),
    [
        ([3, 5], 2, [{3}, {5}]),
        ([0, 1, 2, 3], 3, [{0, 3}, {1}, {2}]),
        ([0, 1], 3, [{0, 1}] * 3),
    ],
)
def test_every_run_has_cores_of_its_own_where_there_are_enough(monkeypatch, cores, jobs: int, expected):
    monkeypatch.setattr(side_by_side, "cores", lambda: cores)
    assert side_by_side.shares(jobs) == expected


def test_an_error_of_bad_input_comes_whole_out_of_another_process():
    error = InputError("--device", "no gpu is to be had", "use --device cpu")
    again = pickle.loads(pickle.dumps(error))
    assert (again.field, again.problem, again.mend, str(again)) == (error.field, error.problem, error.mend, str(error))


@pytest.mark.slow
@pytest.mark.usefixtures("optax_promotion")
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_run_that_cannot_be_done_is_named_and_the_others_are_done(tmp_path, jobs: int):
    # The game of a run that goes on is saved with it, and this one is none.
    first, second = planned(tmp_path)
    RunFolder.create(first.folder, config_to_dict(first.config.resolved()), {"name": "none"})
    failures = carry_out([first, second], jobs)
    assert list(failures) == [first.folder]
    assert "game" in str(failures[first.folder])
    assert RunFolder.open(second.folder).is_finished()
    assert not multiprocessing.active_children()


def test_every_failure_is_said_in_a_line_and_the_last_one_is_raised(tmp_path, capsys):
    errors = [InputError(name, "is damaged", "make another") for name in ("a", "b")]
    with pytest.raises(InputError, match="b: is damaged; make another"):
        refuse_failures(dict(zip([tmp_path / "a", tmp_path / "b"], errors, strict=True)))
    assert capsys.readouterr().err == "gsiirl: a: is damaged; make another\n"
    refuse_failures({})


class Dying(Worker):
    """Stands in for a worker's process: it dies of the first `times` runs it is given, then ends each at once."""

    left = 0

    def __init__(self, share: set[int]) -> None:
        self.share = share
        self.heard, self._telling = multiprocessing.Pipe()
        self.process: Any = SimpleNamespace(kill=lambda: None, join=lambda: None)

    def take(self, planned: PlannedRun) -> None:
        if Dying.left and planned.folder.name == "marl":
            Dying.left -= 1
            self._telling.close()
        else:
            self._telling.send(None)

    def end(self) -> int:
        return -9


@pytest.mark.parametrize(("deaths", "named"), [(0, []), (2, []), (3, ["marl"])])
def test_a_run_whose_process_dies_is_gone_on_with_twice_and_then_named(monkeypatch, tmp_path, deaths: int, named):
    monkeypatch.setattr(side_by_side, "Worker", Dying)
    monkeypatch.setattr(Dying, "left", deaths)
    failures = side_by_side.do_side_by_side(planned(tmp_path), 2, quiet=True)
    assert [folder.name for folder in failures] == named
    assert all("was ended 3 times (status -9)" in str(error) for error in failures.values())
    assert Dying.left == 0


def test_what_a_process_refuses_is_named_and_not_tried_again(monkeypatch, tmp_path):
    refused = InputError("graph", "is damaged", "make another")
    given: list[str] = []

    class Refusing(Dying):
        def take(self, planned: PlannedRun) -> None:
            given.append(planned.folder.name)
            self._telling.send(refused if planned.folder.name == "marl" else None)

    monkeypatch.setattr(side_by_side, "Worker", Refusing)
    failures = side_by_side.do_side_by_side(planned(tmp_path), 2, quiet=True)
    assert {folder.name: str(error) for folder, error in failures.items()} == {"marl": str(refused)}
    assert sorted(given) == ["ma-irl", "marl"]


PLAN = """
import sys
from pathlib import Path
from gsiirl.experiments.config import load_config
from gsiirl.experiments.plans.plan import carry_out
from gsiirl.experiments.plans.planned_run import PlannedRun
from gsiirl.experiments.plans.worker import Worker
from gsiirl.experiments.security.config import SecurityConfig
tiny = {"solver": "soft_joint", "nodes": 4, "edges": 5, "horizon": 3, "seeds": 2, "iterations": 7, "trajectories": 5}
out = Path(sys.argv[1])
planned = [
    PlannedRun(out / name, load_config(SecurityConfig, {**tiny, "algorithm": name})) for name in ("ma-irl", "marl")
]
carry_out(planned, int(sys.argv[2]))
"""


def outcome(folder: Path) -> dict[str, bytes]:
    files = [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".aside"]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files if path.name != "environment.json"}


@pytest.mark.slow
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_plan_killed_again_and_again_ends_as_the_undisturbed_one(tmp_path, jobs: str):
    command = [sys.executable, "-c", PLAN]
    began = time.monotonic()
    subprocess.run([*command, str(tmp_path / "whole"), "1"], check=True, capture_output=True)
    took = (time.monotonic() - began) / int(jobs)
    out = tmp_path / "killed"
    for part in (0.5, 0.8):
        process = subprocess.Popen([*command, str(out), jobs], stdout=subprocess.DEVNULL)
        time.sleep(part * took)
        process.send_signal(signal.SIGKILL)
        process.wait()
    subprocess.run([*command, str(out), jobs], check=True, capture_output=True)
    assert outcome(out) == outcome(tmp_path / "whole")
