"""The commands that look into finished runs. `gsiirl.cli` imports this module only when one of them is asked for."""

import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from gsiirl.errors import InputError
from gsiirl.finished.folders import run_folders
from gsiirl.program.presence import is_file

RUNS = "Folders of runs, or folders that hold such."
FOLDERS = "Folders of runs or of gsiirl theory, or folders that hold such."
NONE_NAMED = ("DIR", "no run folder was named", "give the --out folder of at least one run")


def report(
    *folders: Annotated[Path, Parameter(name="DIR", metavar="DIR", help=FOLDERS)],
    out: Annotated[Path, Parameter(metavar="DIR", help="Folder for the page, the figures and the tables.")],
) -> None:
    """Tables, figures and one HTML page from finished runs and from what `gsiirl theory` measured."""
    if not folders:
        raise InputError(*NONE_NAMED)
    from gsiirl.report import build_report

    build_report(run_folders(folders), out)
    print(out / "index.html")


def table(
    *folders: Annotated[Path, Parameter(name="DIR", metavar="DIR", help=RUNS)],
    by: Annotated[
        str | None,
        Parameter(metavar="FIELDS", help="Settings to group the runs by, with commas; default all that differ."),
    ] = None,
    metric: Annotated[str, Parameter(help="Which metric, of those in summary.json.")] = "deployed_return_learner",
) -> None:
    """One metric of many runs, as Markdown: mean and interval by the settings that differ, and which of two is higher.

    Failed seeds count. Runs that have not ended are left out, and named.
    """
    if not folders:
        raise InputError(*NONE_NAMED)
    from gsiirl.report import swept_table

    runs = [each for each in run_folders(folders) if is_file(each / "config.json")]
    named = None if by is None else [each.strip() for each in by.split(",")]
    text, unfinished = swept_table(runs, named, metric)
    for folder in unfinished:
        print(f"gsiirl: {folder}: has not ended and is left out", file=sys.stderr)
    print(text)


def export(
    folder: Annotated[Path, Parameter(name="DIR", help="Run folder.")],
    /,
    *,
    to: Annotated[Literal["csv", "tensorboard"], Parameter(help="Which files to write.")],
    out: Annotated[Path, Parameter(metavar="DIR", help="Folder for the files: a new or empty one.")],
) -> None:
    """A run's metrics, and as CSV what it learned and its sample paths too, for other programs.

    A run that has not ended is exported as far as it is.
    """
    from gsiirl.finished.csv_files import write_csv_files
    from gsiirl.finished.event_files import write_event_files
    from gsiirl.finished.folders import new_folder
    from gsiirl.runs import RunFolder

    run = RunFolder.open(folder)
    new_folder("--out", out)
    for path in (write_csv_files if to == "csv" else write_event_files)(run, out):
        print(path)
