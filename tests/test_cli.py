import json
import logging
import os
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import gsiirl.experiments
from gsiirl import __version__, scenarios
from gsiirl.cli import main
from gsiirl.errors import InputError
from gsiirl.experiments.config import EXPERIMENTS, ExperimentConfig, config_to_dict
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.program.progress import nobody
from gsiirl.runs import Findings, RunFolder, Summary
from gsiirl.runs.files.json_file import versioned, write_json
from gsiirl.scenarios import load_network

Message = Callable[[list[str]], str]

WHY = "the learner, deployed, ends below random play, or a number is not finite"


@pytest.fixture
def runner(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Stands in for the runner; its `calls` are what it was asked to do."""
    module = ModuleType("gsiirl.experiments.runner")
    calls: list[tuple[object, ...]] = []
    module.__dict__.update(
        calls=calls,
        run=lambda config, out, told=None, rows_to=None: calls.append((config, out)),
        resume=lambda folder, told=None, rows_to=None: calls.append((folder,)),
    )
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(gsiirl.experiments, "runner", module, raising=False)
    return module


@pytest.fixture
def reports(monkeypatch: pytest.MonkeyPatch) -> list[tuple[list[Path], Path]]:
    """What a stand-in of the report was asked to draw."""
    calls: list[tuple[list[Path], Path]] = []

    def build_report(folders: list[Path], out: Path) -> SimpleNamespace:
        calls.append((folders, out))
        return SimpleNamespace(page=out / "index.html")

    module = ModuleType("gsiirl.report")
    module.__dict__.update(build_report=build_report)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    return calls


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Message:
    """The one line with which a command line is refused."""

    def message(argv: list[str]) -> str:
        assert main(argv) == 2
        captured = capsys.readouterr()
        assert captured.out == ""
        [line] = captured.err.splitlines()
        assert line.startswith("gsiirl: ")
        return line.removeprefix("gsiirl: ")

    return message


def make_run(folder: Path, config: ExperimentConfig | None = None, **changes: object) -> Path:
    folder.mkdir(parents=True)
    game = {"format_version": 1, "kind": "attack_graph"}
    write_json(folder / "config.json", versioned(config_to_dict(config or SecurityConfig()) | changes))
    write_json(folder / "game.json", game)
    return folder


def test_version_and_help(capsys: pytest.CaptureFixture[str]):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == __version__
    assert main(["--help"]) == 0
    assert {
        "run",
        "resume",
        "evaluate",
        "transfer",
        "reproduce",
        "theory",
        "report",
        "list",
        "sweep",
        "table",
        "export",
    } <= set(capsys.readouterr().out.split())
    assert main(["run", "security", "--help"]) == 0
    shown = capsys.readouterr().out
    assert "--graph-seed INT" in shown
    assert "Discount gamma. [default: 0.95]" in shown


def test_fields_are_flags(runner: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "run"
    flags = "--algorithm ma-irl --graph tiny --graph-seed=3 --temperature 1e-1 --learner-no-op --no-expert-no-op"
    assert main(["run", "security", *flags.split(), "--out", str(out)]) == 0
    expected = SecurityConfig(algorithm="ma-irl", graph="tiny", graph_seed=3, temperature=0.1, learner_no_op=True)
    assert runner.calls == [(expected, out)]
    [line] = capsys.readouterr().out.splitlines()
    assert f"gsiirl report {out}" in line


def test_what_is_said_of_a_network_is_said_once_in_a_line(
    runner: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    # The configuration reads the network of a run, and the run reads it again.
    runner.__dict__.update(run=lambda config, out, told, rows_to: [load_network(config.graph) for _ in range(2)])
    file = Path(__file__).parent / "data" / "networks" / "undirected.json"
    assert main(["run", "security", "--graph", str(file), "--out", str(tmp_path / "run")]) == 0
    [line] = [line for line in capsys.readouterr().err.splitlines() if "read as" in line]
    assert line == f"gsiirl: {file}: undirected edges (1 of 2) are read as attacks in both directions"


def test_other_warnings_are_as_python_has_them(runner: ModuleType, tmp_path: Path):
    runner.__dict__.update(
        run=lambda config, out, told, rows_to: warnings.warn("of another kind", UserWarning, stacklevel=1)
    )
    with pytest.warns(UserWarning, match="of another kind"):
        main(["run", "security", "--out", str(tmp_path / "run")])


def test_flags_override_the_configuration_file(runner: ModuleType, tmp_path: Path):
    path = tmp_path / "run.toml"
    path.write_text("seeds = 3\nlearner_no_op = true\n")
    assert main(["run", "security", "--config", str(path), "--no-learner-no-op", "--out", "run"]) == 0
    assert runner.calls == [(SecurityConfig(seeds=3), Path("run"))]


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (
            "secruity",
            "secruity: is no command of `gsiirl`; "
            "choose from run, resume, network, evaluate, transfer, sweep, reproduce, ablation, theory, report, table, "
            "export, list",
        ),
        ("rum security", "rum: is no command of `gsiirl`; did you mean run?"),
        ("--verson", "--verson: is no flag of `gsiirl`; did you mean --version?"),
        ("run secruity", "secruity: is no command of `gsiirl run`; did you mean security?"),
        ("run security", "--out: is missing; add --out DIR"),
        ("run security --ot x", "--ot: is no flag of `gsiirl run security`; did you mean --out?"),
        ("run security --out", "--out: has no value; give it as --out DIR"),
        ("run security --out x --seeds", "--seeds: has no value; give it as --seeds INT"),
        ("run security --out x --seed 1", "--seed: is no flag of `gsiirl run security`; did you mean --seeds?"),
        (
            "run security --out x --xyz 1",
            "--xyz: is no flag of `gsiirl run security`; see `gsiirl run security --help`",
        ),
        ("run security --out x --seeds 1 --seeds 2", "--seeds: is given more than once; give it once"),
        ("run security --out x --seeds 0", "--seeds: cannot be 0; give a whole number of at least 1 and at most 10000"),
        (
            "run security --out x --iterations -1",
            "--iterations: cannot be -1; give a whole number of at least 0 and at most 1000000",
        ),
        ("run security --out x --discount 1.5", "--discount: cannot be 1.5; give a number above 0 and at most 1"),
        ("run security --out x --temperature nan", "--temperature: cannot be nan; give a number above 0, or unknown"),
        ("run security --out x --temperature -inf", "--temperature: cannot be -inf; give a number above 0, or unknown"),
        ("run security --out x --temperature 0", "--temperature: cannot be 0; give a number above 0, or unknown"),
        ("run security --out x --temperature abc", "--temperature: cannot be abc; give a number above 0, or unknown"),
        ("run security --out x --variant foo", "--variant: cannot be foo; choose general_sum or zero_sum"),
        (
            "run security --out x --seeds 0 --discount 2",
            "--seeds: cannot be 0; give a whole number of at least 1 and at most 10000",
        ),
        ("run security --out x --learner-no-op=q", "--learner-no-op: cannot be q; see `gsiirl run security --help`"),
        (
            "run security --out x y",
            "y: is one argument too many for `gsiirl run security`; see `gsiirl run security --help`",
        ),
        ("run crossing", "--out: is missing; add --out DIR"),
        (
            "run crossing --out x --graph y",
            "--graph: is no flag of `gsiirl run crossing`; see `gsiirl run crossing --help`",
        ),
        (
            "run crossing --out x --hidden 0",
            "--hidden: cannot be 0; give a whole number of at least 1 and at most 4096",
        ),
        ("run deception --out x --variant foo", "--variant: cannot be foo; choose mpe or separate_target"),
        ("reproduce", "--out: is missing; add --out DIR"),
        ("reproduce --out x --seeds 0", "--seeds: cannot be 0; give a whole number of at least 1 and at most 10000"),
        ("reproduce --out x --quik", "--quik: is no flag of `gsiirl reproduce`; did you mean --quick?"),
        (
            "reproduce --out x --algorithm paper",
            "--algorithm: is no flag of `gsiirl reproduce`; see `gsiirl reproduce --help`",
        ),
        ("report --out x", "DIR: no run folder was named; give the --out folder of at least one run"),
        ("report x", "--out: is missing; add --out DIR"),
        ("resume", "DIR: is missing; add DIR"),
        ("evaluate --in mpe2", "DIR: is missing; add DIR"),
        ("evaluate x", "--in: is missing; add --in mpe2"),
        ("evaluate x --in mpe3", "--in: cannot be mpe3; see `gsiirl evaluate --help`"),
        ("evaluate x --in mpe2 --pair y", "--pair: cannot be y; see `gsiirl evaluate --help`"),
        (
            "evaluate x --in mpe2 --episodes 0",
            "--episodes: cannot be 0; give a whole number of at least 1 and at most 1000000",
        ),
        ("evaluate x --in mpe2", "x: is no folder; give the --out folder of a run"),
        ("transfer", "DIR: is missing; add DIR"),
        ("transfer x", "x: is no folder; give the --out folder of a run"),
        ("transfer x --changes 0", "--changes: cannot be 0; give a whole number of at least 1 and at most 1000"),
        ("theory", "--out: is missing; add --out DIR"),
        ("theory --quik --out x", "--quik: is no flag of `gsiirl theory`; did you mean --quick?"),
    ],
)
def test_bad_input_gets_one_line(command: str, message: str, refused: Message, runner: ModuleType):
    assert refused(command.split()) == message
    assert runner.calls == []


MANY_DIGITS = "9" * 5000


@pytest.mark.parametrize(
    "command",
    [
        "run security --out {out} --seeds 1000000000",
        f"run security --out {{out}} --seeds {MANY_DIGITS}",
        "run security --out {out} --first-seed 99999999999999999999999",
        "run deception --out {out} --first-seed 4294967296",
        "run crossing --out {out} --first-seed 2147483647",
        f"run game --out {{out}} FILE.npz --iterations {MANY_DIGITS}",
        f"evaluate {{out}} --in mpe2 --episodes {MANY_DIGITS}",
        f"reproduce --out {{out}} --jobs {MANY_DIGITS}",
        "reproduce --out {out} --seeds 1000000000",
        f"ablation --out {{out}} --graph-seeds {MANY_DIGITS}",
        "ablation --out {out} --graph-seeds 4294967296",
        f"ablation --out {{out}} --trajectories {MANY_DIGITS}",
    ],
)
def test_numbers_beyond_all_bounds_get_one_short_line_and_no_folder(
    command: str, refused: Message, runner: ModuleType, tmp_path: Path
):
    out = tmp_path / "run"
    message = refused(command.format(out=out).split())
    assert message.startswith("--")
    assert len(message) < 200
    assert runner.calls == []
    assert not out.exists()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("seeds = = 3", "--config: {path} is not TOML (Invalid value (at line 1, column 9)); mend the file"),
        ("seds = 3", "seds in {path}: is no field of the security experiment; did you mean seeds?"),
        ("seeds = 0", "seeds in {path}: cannot be 0; give a whole number of at least 1 and at most 10000"),
    ],
)
def test_a_bad_configuration_file_gets_one_line(content: str, message: str, refused: Message, tmp_path: Path):
    path = tmp_path / "run.toml"
    path.write_text(content)
    assert refused(["run", "security", "--out", "x", "--config", str(path)]) == message.format(path=path)


def test_bad_input_found_by_the_runner_gets_one_line(runner: ModuleType, refused: Message):
    def run(config: SecurityConfig, out: Path, told: object, rows_to: object) -> None:
        raise InputError("--graph", f"{config.graph} is not known", "see `gsiirl list`")

    runner.__dict__["run"] = run
    message = refused(["run", "security", "--graph", "small", "--out", "x"])
    assert message == "--graph: small is not known; see `gsiirl list`"


def test_settings_that_do_not_go_together_get_one_line(refused: Message, tmp_path: Path):
    out = tmp_path / "run"
    message = refused(["run", "deception", "--solver", "maddpg", "--out", str(out)])
    assert message == "solver: maddpg does not go with algorithm gsiirl; use pathwise, or algorithm marl"
    assert not out.exists()


def test_an_error_of_the_program_keeps_its_traceback(runner: ModuleType):
    def run(config: SecurityConfig, out: Path, told: object, rows_to: object) -> None:
        raise ValueError("a fault")

    runner.__dict__["run"] = run
    with pytest.raises(ValueError, match="a fault"):
        main(["run", "security", "--out", "x"])


@pytest.mark.parametrize(("failed", "status"), [([], 0), ([4], 0), ([4, 5], 1)])
def test_failed_seeds_are_named_at_the_end(
    failed: list[int], status: int, runner: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder = make_run(tmp_path / "run")
    RunFolder.open(folder).write_summary(Summary("security", "gsiirl", [4, 5], failed, 5, completed=True, final={}))
    for command in (["run", "security", "--out"], ["resume"]):
        assert main([*command, str(folder)]) == status
        captured = capsys.readouterr()
        assert f"The run is in {folder}" in captured.out
        several = "s"[: len(failed) > 1]
        told = f"gsiirl: {folder}: failed: seed{several} {', '.join(map(str, failed))} ({WHY})\n"
        assert captured.err == (told if failed else "")


def test_a_run_on_a_file_says_which_scale_it_takes_the_rewards_to_have(
    runner: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    path = tmp_path / "euros.json"
    nodes = [{"name": "a", "value": 250_000}, {"name": "b", "value": -1_200_000}]
    edges = [{"source": None, "target": name, "success_probability": 0.5} for name in "ab"]
    path.write_text(json.dumps({"nodes": nodes, "edges": edges}))
    command = ["run", "security", "--graph", str(path), "--out", str(tmp_path / "run")]
    assert main(command) == 0
    scale = "temperature 480,000 (0.4 x the largest value or attack cost), bound of a reward weight 1,200,000"
    assert capsys.readouterr().err == f"gsiirl: {path}: {scale}\n"
    assert main([*command, "--temperature", "3"]) == 0
    assert capsys.readouterr().err == f"gsiirl: {path}: temperature 3, bound of a reward weight 1,200,000\n"


def test_an_interrupted_run_says_how_to_go_on(runner: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    runner.__dict__.update(run=interrupt, resume=interrupt)
    assert main(["run", "security", "--out", str(tmp_path / "nothing")]) == 130
    assert capsys.readouterr().err == "gsiirl: interrupted: nothing was written yet\n"
    folder = make_run(tmp_path / "a run")
    for command in (["run", "security", "--out"], ["resume"]):
        assert main([*command, str(folder)]) == 130
        assert capsys.readouterr().err == f"gsiirl: interrupted: go on with `gsiirl resume '{folder}'`\n"


@pytest.mark.parametrize("kind", EXPERIMENTS.values())
def test_resume_goes_on_with_a_run_of_any_experiment(kind: type[ExperimentConfig], runner: ModuleType, tmp_path: Path):
    folder = make_run(tmp_path / "run", kind())
    assert main(["resume", str(folder)]) == 0
    assert runner.calls == [(folder,)]


def test_reproduce_runs_the_plan_and_reports_it(
    runner: ModuleType,
    reports: list[tuple[list[Path], Path]],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    refused: Message,
):
    def run(config: ExperimentConfig, folder: Path, told: object) -> None:
        runner.calls.append((config, folder))
        make_run(folder, config.resolved())
        failed = [1] if folder == tmp_path / "crossing" / "paper" else []
        summary = Summary(config.experiment, config.algorithm, [0, 1], failed, 5, completed=True, final={})
        RunFolder.open(folder).write_summary(summary)

    runner.__dict__["run"] = run
    command = ["reproduce", "--quick", "--jobs", "1", "--out", str(tmp_path)]
    assert main(command) == 0
    captured = capsys.readouterr()
    assert captured.out == f"{tmp_path / 'report' / 'index.html'}\n"
    assert captured.err == f"gsiirl: {tmp_path / 'crossing' / 'paper'}: failed: seed 1 ({WHY})\n"
    folders = [folder for _, folder in runner.calls]
    assert len(folders) == 12
    # The longest runs begin first, and stand last in the report.
    assert (folders[0], folders[-1]) == (tmp_path / "deception" / "marl", tmp_path / "security-zero-sum" / "gsiirl")
    assert reports == [(folders[::-1], tmp_path / "report")]
    assert {config.seeds for config, _ in runner.calls} == {2}
    # Again, what is not finished is gone on with, and nothing else; with other settings it is refused.
    first = tmp_path / "security-zero-sum" / "gsiirl"
    (first / "summary.json").unlink()
    assert main(command) == 0
    assert runner.calls[12:] == [(first,)]
    capsys.readouterr()
    message = f"--out: {first} holds a run with other settings; use another folder"
    assert refused([*command, "--seeds", "3"]) == message
    assert len(runner.calls) == 13
    message = "--jobs: cannot be 0; give a whole number of at least 1 and at most 1000"
    assert refused(["reproduce", "--jobs", "0", "--out", "x"]) == message


def test_an_interrupted_reproduction_says_how_to_go_on(
    runner: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    runner.__dict__["run"] = interrupt
    assert main(["reproduce", "--maddpg", "--jobs", "1", "--out", str(tmp_path)]) == 130
    again = f"gsiirl reproduce --maddpg --jobs 1 --seeds 10 --out {tmp_path}"
    assert capsys.readouterr().err == f"gsiirl: interrupted: finished runs are kept; go on with `{again}`\n"


def test_a_damaged_run_is_not_resumed(runner: ModuleType, tmp_path: Path, refused: Message):
    folder = make_run(tmp_path / "run", seeds=0)
    path = folder / "config.json"
    assert refused(["resume", str(folder)]).startswith(f"seeds in {path}: cannot be 0; ")
    path.write_text("{")
    assert str(path) in refused(["resume", str(folder)])
    path.unlink()
    assert str(folder) in refused(["resume", str(folder)])
    assert runner.calls == []


def test_report_takes_runs_and_folders_of_runs(
    reports: list[tuple[list[Path], Path]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    first, second, third = (make_run(tmp_path / name) for name in ("all/a", "all/b", "other"))
    (tmp_path / "all" / "notes").mkdir()
    out = tmp_path / "report"
    assert main(["report", str(third), str(tmp_path / "all"), str(first), "--out", str(out)]) == 0
    assert reports == [([third, first, second], out)]
    assert capsys.readouterr().out == f"{out / 'index.html'}\n"


def test_report_refuses_a_folder_without_runs(reports: list[tuple[list[Path], Path]], tmp_path: Path, refused: Message):
    assert refused(["report", str(tmp_path), "--out", "x"]).startswith(f"{tmp_path}: neither is nor holds a run")
    missing = tmp_path / "missing"
    assert refused(["report", str(missing), "--out", "x"]).startswith(f"{missing}: is no folder")
    assert reports == []


def test_report_takes_what_the_theory_measured(reports: list[tuple[list[Path], Path]], tmp_path: Path):
    run, theory = make_run(tmp_path / "all" / "a"), tmp_path / "all" / "b"
    Findings(False, []).write(theory)
    assert main(["report", str(tmp_path / "all"), "--out", "x"]) == 0
    assert main(["report", str(theory), "--out", "x"]) == 0
    assert [folders for folders, _ in reports] == [[run, theory], [theory]]


def test_theory_refuses_what_is_not_its_own(refused: Message, tmp_path: Path):
    file = tmp_path / "file"
    file.write_text("mine")
    assert refused(["theory", "--out", str(file)]) == f"--out: {file} is a file; use another folder"
    run = make_run(tmp_path / "run")
    assert refused(["theory", "--out", str(run)]) == f"--out: {run} holds a run; use a new or empty folder"
    assert (
        refused(["theory", "--out", str(tmp_path)]) == f"--out: {tmp_path} holds other files; use a new or empty folder"
    )


def test_list_names_what_is_known(capsys: pytest.CaptureFixture[str]):
    assert main(["list"]) == 0
    known = {line.split()[0]: line.split(maxsplit=1)[1] for line in capsys.readouterr().out.splitlines()}
    assert list(known) == ["experiments", "scenarios", "algorithms", "solvers", "experts"]
    assert known["experiments"] == "security, crossing, deception, game"
    assert known["solvers"] == "logit, soft_joint, q_learning, pathwise, maddpg"
    assert known["algorithms"] == "gsiirl, paper, ma-irl, lin2019, marl"
    assert "small-linear" in known["scenarios"].split(", ")


def test_the_program_exits_with_the_status_of_main():
    arguments = ["run", "security", "--seeds", "0", "--out", "x"]
    finished = subprocess.run([sys.executable, "-m", "gsiirl", *arguments], capture_output=True, text=True, check=False)
    assert finished.returncode == 2
    assert finished.stderr == "gsiirl: --seeds: cannot be 0; give a whole number of at least 1 and at most 10000\n"
    assert finished.stdout == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_an_output_that_cannot_be_written_is_one_line(unbuffered: str):
    command = [sys.executable, "-m", "gsiirl", "list"]
    environment = os.environ | {"PYTHONUNBUFFERED": unbuffered}
    with Path("/dev/full").open("w") as full:
        told = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, env=environment, check=False)
        untold = subprocess.run([*command, "--x"], stdout=full, stderr=full, env=environment, check=False)
    problem = "gsiirl: standard output: cannot be written (No space left on device)"
    assert (told.returncode, told.stderr) == (2, f"{problem}; make room for it, or send it elsewhere\n")
    assert untold.returncode == 2


def test_matplotlib_is_not_heard_about_a_user_without_a_home_folder():
    logger = logging.getLogger("matplotlib")
    logger.setLevel(logging.NOTSET)
    assert main(["list"]) == 0
    assert not logger.isEnabledFor(logging.WARNING)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_that_python_would_forget_is_none_the_less_one(
    number: signal.Signals, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    class Collected:
        def __del__(self) -> None:
            signal.raise_signal(number)

    def known() -> list[str]:
        Collected()
        for _ in range(500):
            time.sleep(0.01)
        return []

    monkeypatch.setattr(scenarios, "known_scenarios", known)
    hook = sys.unraisablehook
    # A process that a shell started in the background ignores Ctrl-C.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        assert main(["list"]) == 130
    finally:
        signal.signal(signal.SIGINT, before)
    assert capsys.readouterr() == ("", "gsiirl: interrupted\n")
    assert sys.unraisablehook is hook


def test_a_run_that_is_ended_by_its_cluster_is_interrupted(
    runner: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder = make_run(tmp_path / "run")

    def ended(*_: object) -> None:
        signal.raise_signal(signal.SIGTERM)

    runner.__dict__["resume"] = ended
    before = signal.getsignal(signal.SIGTERM)
    assert main(["resume", str(folder)]) == 130
    assert capsys.readouterr().err == f"gsiirl: interrupted: go on with `gsiirl resume {folder}`\n"
    assert signal.getsignal(signal.SIGTERM) == before


def test_in_quiet_the_runner_is_given_somebody_to_tell(runner: ModuleType, tmp_path: Path):
    told: list[object] = []
    runner.__dict__["run"] = lambda config, out, told_to, rows_to: told.append(told_to)
    assert main(["run", "security", "--out", str(tmp_path / "run")]) == 0
    assert main(["run", "security", "--quiet", "--out", str(tmp_path / "run")]) == 0
    assert told == [None, nobody]


@pytest.mark.parametrize(
    "command",
    [
        "resume {}", "report {} --out x", "evaluate {} --in mpe2", "run security --config {} --out x",
        "reproduce --out {}", "ablation --out {}", "theory --out {}",
    ],
)  # fmt: skip
def test_a_name_that_no_file_system_takes_gets_one_line(command: str, refused: Message, runner: ModuleType):
    assert "File name too long" in refused(command.format(300 * "x").split())
    assert runner.calls == []


def test_what_nobody_has_better_words_for_gets_one_line(runner: ModuleType, refused: Message):
    def run(*_: object) -> None:
        Path("/proc/nothing/here").read_text()

    runner.__dict__["run"] = run
    expected = "/proc/nothing/here: cannot be used (No such file or directory); use another, or allow it"
    assert refused(["run", "security", "--out", "x"]) == expected


def test_a_run_of_an_earlier_version_is_gone_on_with_and_told_in_one_line(
    runner: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    folder = make_run(tmp_path / "run")
    for path in folder.iterdir():
        content = json.loads(path.read_text())
        path.write_text(json.dumps({name: value for name, value in content.items() if name != "checksum"}))
    for _ in range(2):
        assert main(["resume", str(folder)]) == 0
        told = f"gsiirl: {folder} was written before files carried checksums: damage to it may go unseen\n"
        assert capsys.readouterr().err == told


@pytest.mark.parametrize("command", ["resume {}", "report {} --out {}-r", "table {}", "export {} --to csv --out {}-e"])
def test_a_folder_of_another_format_is_refused_in_one_line_and_left_alone(
    command: str, tmp_path: Path, refused: Message
):
    folder = RunFolder.create(tmp_path / "run", config_to_dict(SecurityConfig(seeds=2)), {"name": "none"}).path
    for name in ("config.json", "game.json"):
        content = json.loads((folder / name).read_text()) | {"format_version": 2}
        (folder / name).write_text(json.dumps({key: value for key, value in content.items() if key != "checksum"}))
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    line = refused(command.replace("{}", str(folder)).split())
    assert "unknown format_version 2; this version of gsiirl reads format_version 1: use the version that wrote" in line
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
