"""Several runs, each into a folder of its own; what is done is kept when they are begun again."""

from collections.abc import Sequence
from pathlib import Path

from gsiirl.errors import InputError
from gsiirl.experiments.config import ExperimentConfig, config_from_dict
from gsiirl.experiments.plans.planned_run import PlannedRun, do, is_finished
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
        if RunFolder.is_at(above) or above.is_file():
            raise InputError("--out", f"{above} {'is a file' if above.is_file() else 'holds a run'}", MEND)
    if RunFolder.is_at(folder):
        if config_from_dict(RunFolder.open(folder).config, folder / "config.json") != config:
            raise InputError("--out", f"{folder} holds a run with other settings", MEND)
    elif folder.exists() and not (folder.is_dir() and RunFolder.is_free(folder)):
        raise InputError("--out", f"{folder} {'holds other files' if folder.is_dir() else 'is a file'}", MEND)


def carry_out(planned: Sequence[PlannedRun], jobs: int = 1, quiet: bool = False) -> None:
    """Do every run that is not done yet, `jobs` at a time, going on with what was interrupted; in `quiet`, or shown.

    Raises:
        InputError: see `check_folders`, and `runner.run`; runs after the one concerned are not begun.
    """
    check_folders(planned)
    unfinished = [each for each in planned if not is_finished(each.folder)]
    for finished in {each.folder for each in planned} - {each.folder for each in unfinished}:
        clear_lock(finished)
    if not unfinished:
        return
    if jobs > 1:
        from gsiirl.experiments.plans.side_by_side import do_side_by_side

        do_side_by_side(unfinished, jobs, quiet)
        return
    import jax

    for each in unfinished:
        do(each, nobody if quiet else None)
        # A plan has many programs, and none is used by two runs.
        jax.clear_caches()


def failed_seeds(planned: Sequence[PlannedRun]) -> dict[Path, list[int]]:
    """The seeds that failed, of every finished run in which any did."""
    summaries = {folder: RunFolder.open(folder).summary() for folder, _ in planned}
    return {folder: each.failed_seeds for folder, each in summaries.items() if each and each.failed_seeds}
