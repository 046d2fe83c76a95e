"""Several runs, each into a folder of its own; what is done is kept when they are begun again."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from gsiirl.errors import InputError
from gsiirl.experiments.config import ExperimentConfig, config_from_dict
from gsiirl.runs import RunFolder

UNBEGUN = {"game.json", "game.json.aside", "config.json.aside"}
"""What a run that was killed before its `config.json` was there may have left."""


class PlannedRun(NamedTuple):
    """A configuration, and where its run is or will be."""

    folder: Path
    config: ExperimentConfig


def check_folders(planned: Sequence[PlannedRun]) -> None:
    """See that every folder is free, or holds the run that is planned for it; nothing is written.

    Raises:
        InputError: for the first folder that holds anything else, or the first configuration that cannot be used.
    """
    for folder, config in planned:
        config = config.resolved()
        for above in folder.parents:
            if RunFolder.is_at(above) or above.is_file():
                held = "is a file" if above.is_file() else "holds a run"
                raise InputError("--out", f"{above} {held}", "use another folder")
        if RunFolder.is_at(folder):
            if config_from_dict(RunFolder.open(folder).config, folder / "config.json") != config:
                raise InputError("--out", f"{folder} holds a run with other settings", "use another folder")
        elif folder.exists() and not (folder.is_dir() and _names_in(folder) <= UNBEGUN):
            held = "holds other files" if folder.is_dir() else "is a file"
            raise InputError("--out", f"{folder} {held}", "use another folder")


def carry_out(planned: Sequence[PlannedRun], jobs: int = 1) -> None:
    """Do every run that is not done yet, `jobs` at a time, going on with what was interrupted.

    Raises:
        InputError: see `check_folders`, and `runner.run`; runs after the one concerned are not begun.
    """
    check_folders(planned)
    unfinished = [each for each in planned if not is_finished(each.folder)]
    if not unfinished:
        return
    if jobs > 1:
        from gsiirl.experiments.side_by_side import do_side_by_side

        do_side_by_side(unfinished, jobs)
        return
    import jax

    for each in unfinished:
        do(each)
        # A plan has many programs, and none is used by two runs.
        jax.clear_caches()


def do(planned: PlannedRun, told: Callable[[int, int], None] | None = None) -> None:
    """Begin a run, or go on with it; its progress is shown, or told to `told` (see `runner.Told`)."""
    from gsiirl.experiments import runner

    folder, config = planned
    if RunFolder.is_at(folder):
        runner.resume(folder, told)
    else:
        _clear(folder)
        runner.run(config, folder, told)


def cores() -> list[int]:
    """The processor cores that this process may use, by number where the system tells."""
    return sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [*range(os.cpu_count() or 1)]


def failed_seeds(planned: Sequence[PlannedRun]) -> dict[Path, list[int]]:
    """The seeds that failed, of every finished run in which any did."""
    summaries = {folder: RunFolder.open(folder).summary() for folder, _ in planned}
    return {folder: each["failed_seeds"] for folder, each in summaries.items() if each and each["failed_seeds"]}


def is_finished(folder: Path) -> bool:
    """Whether `folder` holds a run that has ended."""
    return RunFolder.is_at(folder) and RunFolder.open(folder).is_finished()


def _names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def _clear(folder: Path) -> None:
    for name in UNBEGUN:
        (folder / name).unlink(missing_ok=True)
