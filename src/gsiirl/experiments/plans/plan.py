"""Several runs, each into a folder of its own; what is done is kept when they are begun again."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from gsiirl.errors import InputError
from gsiirl.experiments.config import ExperimentConfig, config_from_dict
from gsiirl.experiments.plans.planned_run import PlannedRun, is_finished
from gsiirl.program.presence import is_file, is_folder, is_there
from gsiirl.program.progress import nobody
from gsiirl.runs import RunFolder, clear_lock
from gsiirl.runs.files.damage import refuse_unreadable

MEND = "use another folder"


def check_folders(planned: Sequence[PlannedRun]) -> None:
    """See that every folder is free, or holds the run that is planned for it; nothing is written.

    Raises:
        InputError: for the first folder that holds anything else, or the first configuration that cannot be used.
    """
    for folder, config in planned:
        with refuse_unreadable("--out", folder, MEND):
            _check_folder(folder, config.resolved())


def _check_folder(folder: Path, config: ExperimentConfig) -> None:
    for above in folder.parents:
        if RunFolder.is_at(above) or is_file(above):
            raise InputError("--out", f"{above} {'is a file' if is_file(above) else 'holds a run'}", MEND)
    if RunFolder.is_at(folder):
        if config_from_dict(RunFolder.open(folder).config, folder / "config.json") != config:
            raise InputError("--out", f"{folder} holds a run with other settings", MEND)
    elif is_there(folder) and not (is_folder(folder) and RunFolder.is_free(folder)):
        raise InputError("--out", f"{folder} {'holds other files' if is_folder(folder) else 'is a file'}", MEND)


def carry_out(
    planned: Sequence[PlannedRun], jobs: int = 1, quiet: bool = False, cluster: str | None = None
) -> dict[Path, InputError]:
    """Do every run that is not done yet, going on with what was interrupted; in `quiet`, or shown.

    `jobs` runs are done at a time on this machine; or on the Ray cluster at the address `cluster`, as many as it has
    processor cores. Returned is, by folder, why a run could not be done; the others are done all the same.

    Raises:
        InputError: see `check_folders`; nothing is begun then.
    """
    check_folders(planned)
    unfinished = [each for each in planned if not is_finished(each.folder)]
    for finished in {each.folder for each in planned} - {each.folder for each in unfinished}:
        clear_lock(finished)
    if not unfinished:
        return {}
    if cluster is not None:
        from gsiirl.experiments.plans.on_ray import do_on_ray

        return do_on_ray(unfinished, cluster, jobs, quiet)
    if jobs > 1:
        from gsiirl.experiments.plans.side_by_side import do_side_by_side

        return do_side_by_side(unfinished, jobs, quiet)
    from gsiirl.experiments.plans.worker import tried

    found = {each.folder: tried(each, nobody if quiet else None) for each in unfinished}
    return {folder: error for folder, error in found.items() if error is not None}


def refuse_failures(failures: Mapping[Path, InputError]) -> None:
    """Say of every run that could not be done why.

    Raises:
        InputError: the last of them; those before it are printed.
    """
    *others, last = [None, *failures.values()]
    for error in others[1:]:
        print(f"gsiirl: {error}", file=sys.stderr)
    if last is not None:
        raise last


def failed_seeds(planned: Sequence[PlannedRun]) -> dict[Path, list[int]]:
    """The seeds that failed, of every finished run in which any did."""
    summaries = {folder: RunFolder.open(folder).summary() for folder, _ in planned}
    return {folder: each.failed_seeds for folder, each in summaries.items() if each and each.failed_seeds}
