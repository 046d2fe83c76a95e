"""The commands of many runs. `gsiirl.cli` imports this module only when one of them is asked for."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from gsiirl.errors import InputError
from gsiirl.experiments.commands import Quiet, print_failed
from gsiirl.experiments.config import at_least_one, flag, load_config
from gsiirl.experiments.plans.plan import carry_out, check_folders, failed_seeds, refuse_failures
from gsiirl.experiments.plans.planned_run import HERE, PlannedRun, is_finished
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.program.command import command
from gsiirl.program.cores import cores
from gsiirl.runs import RunFolder

MOST_JOBS = 1000
MOST_AT_A_TIME = 4
"""Runs at a time, where nothing else is asked for: each takes memory."""

Jobs = Annotated[
    str | None,
    Parameter(metavar="INT", help=f"Runs at a time; default one a processor core, {MOST_AT_A_TIME} at most."),
]


def sweep(
    file: Annotated[Path, Parameter(name="SWEEP.toml", help="Fields of an experiment, lists for those that vary.")],
    /,
    *,
    out: Annotated[Path, Parameter(metavar="DIR", help="Folder for the runs; one of an earlier call is gone on with.")],
    list_runs: Annotated[
        bool, Parameter(name="--list", negative="", help="Only say which runs there are, and how far each is.")
    ] = False,
    part: Annotated[
        str | None, Parameter(metavar="K/N", help="Only every Nth run, from the Kth on: one job of N of a queue.")
    ] = None,
    jobs: Jobs = None,
    engine: Annotated[
        Literal["local", "ray"], Parameter(help="Processes of this machine, or workers of a Ray cluster.")
    ] = "local",
    address: Annotated[
        str | None, Parameter(metavar="HOST:PORT", help="The Ray cluster; default one of this machine alone.")
    ] = None,
    quiet: Quiet = False,
) -> int:
    """Every combination of the values that a file gives for the fields of an experiment.

    Finished runs in DIR are kept and interrupted ones are gone on with. What cannot be done is named at the end.
    """
    from gsiirl.experiments.plans.sweep import part_of, read_sweep

    if address is not None and engine == "local":
        raise InputError("--address", "is of a Ray cluster", "add --engine ray, or leave it out")
    planned, at_a_time = part_of(read_sweep(file, out), part), _at_a_time(jobs)
    if list_runs:
        check_folders(planned)
        for each in planned:
            print(f"{each.folder.name}: {_state(each)}")
        return 0
    cluster = HERE if address is None else address
    try:
        failures = carry_out(planned, at_a_time, quiet, None if engine == "local" else cluster)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("finished runs are kept; the same command goes on") from None
    finished = [each for each in planned if is_finished(each.folder)]
    _print_failed_seeds(finished)
    words = f"{len(finished)} of {len(planned)} runs are finished"
    print(
        f"{words}; `{command('table', out)}` compares them, `{command('report', out, '--out', f'{out}-report')}` draws."
    )
    refuse_failures(failures)
    return 0


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
    jobs: Jobs = None,
    out: Annotated[
        Path,
        Parameter(metavar="DIR", help="Folder for the runs and the report; one of an earlier call is gone on with."),
    ],
    quiet: Quiet = False,
) -> None:
    """Every algorithm on security, crossing and deception, then the report: the paper's Table 1 and Figures 2-4.

    Finished runs in DIR are kept and an interrupted one is gone on with.
    """
    from gsiirl.experiments.plans.reproduce import plan

    number = load_config(SecurityConfig, {"seeds": (2 if quick else 10) if seeds is None else seeds}, flag).seeds
    at_a_time = _at_a_time(jobs)
    planned = plan(out, number, quick, maddpg)
    # Before anything slow is imported, so that bad input is answered at once.
    check_folders(planned)
    from gsiirl.report import build_report

    try:
        # The longest come last in a report; begun first, all end at about the same time.
        refuse_failures(carry_out(planned[::-1], at_a_time, quiet))
        page = build_report([each.folder for each in planned], out / "report").page
    except KeyboardInterrupt:
        flags = [f"--{name}" for name, given in (("quick", quick), ("maddpg", maddpg)) if given]
        flags += [] if jobs is None else ["--jobs", jobs]
        again = command("reproduce", *flags, "--seeds", number, "--out", out)
        raise KeyboardInterrupt(f"finished runs are kept; go on with `{again}`") from None
    _print_failed_seeds(planned)
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
    jobs: Jobs = None,
    quiet: Quiet = False,
) -> None:
    """What each change of the default over the paper's preset is worth, on random attack graphs.

    Finished runs in DIR are kept and an interrupted one is gone on with.
    """
    given = {"seeds": seeds, "iterations": iterations, "trajectories": trajectories}
    load_config(SecurityConfig, given, flag)
    graphs, at_a_time = [_seed("--graph-seeds", each) for each in graph_seeds.split(",")], _at_a_time(jobs)
    from gsiirl.experiments.plans.ablation import run_ablation
    from gsiirl.report import write_ablation_page

    try:
        run_ablation(given, graphs, out, at_a_time, quiet)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("finished runs are kept; the same command goes on") from None
    print(write_ablation_page(out))


def _at_a_time(jobs: str | None) -> int:
    return min(len(cores()), MOST_AT_A_TIME) if jobs is None else at_least_one("--jobs", jobs, MOST_JOBS)


def _state(each: PlannedRun) -> str:
    """How far a run is."""
    if not RunFolder.is_at(each.folder):
        return "not begun"
    folder = RunFolder.open(each.folder)
    if folder.is_finished():
        return "finished"
    checkpoint = folder.load_checkpoint()
    return f"{0 if checkpoint is None else checkpoint.iteration} iterations done"


def _print_failed_seeds(planned: list[PlannedRun]) -> None:
    for folder, failed in failed_seeds(planned).items():
        print_failed(folder, failed)


def _seed(name: str, text: str) -> int:
    try:
        number = int(text)
    except ValueError:
        number = -1
    if not 0 <= number < 2**31:
        problem = f"cannot be {text[:40] or 'empty'}"
        raise InputError(name, problem, f"give whole numbers from 0 to {2**31 - 1}, with commas between")
    return number
