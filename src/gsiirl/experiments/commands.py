"""The commands that run an experiment. `gsiirl.cli` imports this module only when one of them is asked for."""

import inspect
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from gsiirl.errors import InputError
from gsiirl.experiments.config import (
    ExperimentConfig,
    at_least_one,
    choices,
    config_from_dict,
    field_schemas,
    flag,
    load_config,
    load_config_file,
)
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.game.config import GameConfig
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.program.command import command
from gsiirl.program.progress import nobody

MOST_JOBS = 1000

Quiet = Annotated[bool, Parameter(negative="", help="Show no progress.")]
Out = Annotated[Path, Parameter(metavar="DIR", help="Run folder to make: a new or empty folder.")]
ConfigFile = Annotated[
    Path | None,
    Parameter(metavar="FILE", help="TOML file with any of the fields below (discount = 0.9); flags override it."),
]


def _with_field_flags(kind: type[ExperimentConfig]) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Of a command: a flag for each field of its configuration in place of its `**flags`."""

    def with_flags(command: Callable[..., int]) -> Callable[..., int]:
        signature = inspect.signature(command)
        own = [each for each in signature.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
        # What a command takes as an argument of its own is no flag too.
        taken = {each.name for each in own}
        flags = [_flag(field, schema) for field, schema in field_schemas(kind).items() if field not in taken]
        setattr(command, "__signature__", signature.replace(parameters=[*own, *flags]))  # noqa: B010 (not a declared attribute)
        return command

    return with_flags


def _flag(field: str, schema: dict[str, Any]) -> inspect.Parameter:
    """The flag of a field. Its value stays a text, to be checked together with those of the configuration file."""
    default = schema["default"]
    if schema["type"] == "boolean":
        kind: Any = bool | None if default is None else bool
    else:
        kind, default = str | None, None if default is None else str(default)
    metavar = "|".join(choices(schema)) or {"integer": "INT", "number": "FLOAT"}.get(schema["type"], "TEXT")
    annotation = Annotated[kind, Parameter(help=schema["description"], metavar=metavar)]
    return inspect.Parameter(field, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


@_with_field_flags(SecurityConfig)
def security(*, out: Out, config: ConfigFile = None, quiet: Quiet = False, **flags: Any) -> int:
    """A defender lives with an attacker on an attack graph."""
    return _run(SecurityConfig, out, config, quiet, flags)


@_with_field_flags(CrossingConfig)
def crossing(*, out: Out, config: ConfigFile = None, quiet: Quiet = False, **flags: Any) -> int:
    """A robot crosses the way of a human."""
    return _run(CrossingConfig, out, config, quiet, flags)


@_with_field_flags(DeceptionConfig)
def deception(*, out: Out, config: ConfigFile = None, quiet: Quiet = False, **flags: Any) -> int:
    """Two agents keep an adversary from their target."""
    return _run(DeceptionConfig, out, config, quiet, flags)


@_with_field_flags(GameConfig)
def game(
    file: Annotated[
        str | None,
        Parameter(name="FILE", metavar="FILE", help="FILE.npz with the game's arrays, or FILE.py:NAME, a function."),
    ] = None,
    /,
    *,
    out: Out,
    config: ConfigFile = None,
    quiet: Quiet = False,
    **flags: Any,
) -> int:
    """Your own finite game."""
    return _run(GameConfig, out, config, quiet, flags | ({} if file is None else {"file": file}))


def _run(kind: type[ExperimentConfig], out: Path, file: Path | None, quiet: bool, flags: dict[str, Any]) -> int:
    configuration = load_config_file(kind, file, flags)
    if isinstance(configuration, SecurityConfig):
        _say_before(configuration)
    from gsiirl.experiments import runner

    with _resumable(out):
        runner.run(configuration, out, nobody if quiet else None)
    return _print_end(out)


def _say_before(config: SecurityConfig) -> None:
    """The scale of the rewards in a file, and the time of a long run."""
    from gsiirl.experiments.security.cost import warning_of

    for line in (config.scales_of_file(), warning_of(config.resolved())):
        if line is not None:
            print(f"gsiirl: {line}", file=sys.stderr)


def resume(folder: Annotated[Path, Parameter(name="DIR", help="Run folder.")], /, *, quiet: Quiet = False) -> int:
    """Go on with an interrupted run."""
    from gsiirl.runs import RunFolder

    config_from_dict(RunFolder.open(folder).config, folder / "config.json")
    from gsiirl.experiments import runner

    with _resumable(folder):
        runner.resume(folder, nobody if quiet else None)
    return _print_end(folder)


def reproduce(
    *,
    quick: Annotated[
        bool,
        Parameter(negative="", help="2 seeds and few iterations, the paper's variant of security only: minutes."),
    ] = False,
    seeds: Annotated[
        str | None, Parameter(metavar="INT", help="Number of seeds; default 10, and 2 with --quick.")
    ] = None,
    maddpg: Annotated[bool, Parameter(negative="", help="Also MARL by the paper's MADDPG.")] = False,
    jobs: Annotated[
        str | None, Parameter(metavar="INT", help="Runs at a time; default one a processor core, 4 at most.")
    ] = None,
    out: Annotated[
        Path,
        Parameter(metavar="DIR", help="Folder for the runs and the report; one of an earlier call is gone on with."),
    ],
    quiet: Quiet = False,
) -> None:
    """Every algorithm on security, crossing and deception, then the report: the paper's Table 1 and Figures 2-4.

    Finished runs in DIR are kept and an interrupted one is gone on with.
    """
    number = load_config(SecurityConfig, {"seeds": (2 if quick else 10) if seeds is None else seeds}, flag).seeds
    from gsiirl.experiments.plans.plan import carry_out, check_folders, failed_seeds
    from gsiirl.experiments.plans.planned_run import cores
    from gsiirl.experiments.plans.reproduce import plan

    at_a_time = min(len(cores()), 4) if jobs is None else at_least_one("--jobs", jobs, MOST_JOBS)
    planned = plan(out, number, quick, maddpg)
    # Before anything slow is imported, so that bad input is answered at once.
    check_folders(planned)
    from gsiirl.report import build_report

    try:
        # The longest come last in a report; begun first, all end at about the same time.
        carry_out(planned[::-1], at_a_time, quiet)
        page = build_report([each.folder for each in planned], out / "report").page
    except KeyboardInterrupt:
        flags = [f"--{name}" for name, given in (("quick", quick), ("maddpg", maddpg)) if given]
        flags += [] if jobs is None else ["--jobs", jobs]
        again = command("reproduce", *flags, "--seeds", number, "--out", out)
        raise KeyboardInterrupt(f"finished runs are kept; go on with `{again}`") from None
    for folder, failed in failed_seeds(planned).items():
        _print_failed(folder, failed)
    print(page)


def ablation(
    *,
    out: Annotated[
        Path, Parameter(metavar="DIR", help="Folder for the runs and the page; one of an earlier call is gone on with.")
    ],
    graph_seeds: Annotated[
        str, Parameter(metavar="SEEDS", help="Seeds of the random graphs, with commas between them.")
    ] = "0,1,2,3,4",
    seeds: Annotated[str, Parameter(metavar="INT", help="Number of seeds.")] = "10",
    iterations: Annotated[str, Parameter(metavar="INT", help="Outer iterations.")] = "50",
    trajectories: Annotated[str, Parameter(metavar="INT", help="Trajectories of each interaction.")] = "100",
    quiet: Quiet = False,
) -> None:
    """What each change of the default over the paper's preset is worth, on random attack graphs.

    Finished runs in DIR are kept and an interrupted one is gone on with.
    """
    given = {"seeds": seeds, "iterations": iterations, "trajectories": trajectories}
    load_config(SecurityConfig, given, flag)
    graphs = [_whole("--graph-seeds", each) for each in graph_seeds.split(",")]
    from gsiirl.experiments.plans.ablation import run_ablation
    from gsiirl.report import write_ablation_page

    try:
        run_ablation(given, graphs, out, quiet)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("finished runs are kept; the same command goes on") from None
    print(write_ablation_page(out))


def _whole(name: str, text: str) -> int:
    try:
        number = int(text)
    except ValueError:
        number = -1
    if not 0 <= number < 2**31:
        problem = f"cannot be {text[:40] or 'empty'}"
        raise InputError(name, problem, f"give whole numbers from 0 to {2**31 - 1}, with commas between")
    return number


@contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        if not (folder / "config.json").is_file():
            raise KeyboardInterrupt("nothing was written yet") from None
        raise KeyboardInterrupt(f"go on with `{command('resume', folder)}`") from None


def _print_end(folder: Path) -> int:
    """Say where the run is and which of its seeds failed; the exit status is 1 where all did."""
    from gsiirl.runs import RunFolder

    report = command("report", folder, "--out", f"{folder}-report")
    print(f"The run is in {shlex.quote(str(folder))}; `{report}` makes its tables and figures.")
    summary = RunFolder.open(folder).summary() if RunFolder.is_at(folder) else None
    if summary is None or not summary.failed_seeds:
        return 0
    _print_failed(folder, summary.failed_seeds)
    return 1 if summary.failed_seeds == summary.seeds else 0


def _print_failed(folder: Path, seeds: list[int]) -> None:
    why = "the learner, deployed, ends below random play, or a number is not finite"
    print(f"gsiirl: {folder}: failed seeds {', '.join(map(str, seeds))} ({why})", file=sys.stderr)
