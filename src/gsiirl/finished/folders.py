"""Which run folders a user means."""

from collections.abc import Iterable
from pathlib import Path

from gsiirl.errors import InputError
from gsiirl.program.presence import is_file, is_folder, is_there
from gsiirl.runs.files.atomic import refuse_unwritable


def run_folders(folders: Iterable[Path]) -> list[Path]:
    """The folders of runs and findings named, each once; of a folder that is none itself, those below it.

    These are the ones directly below it or, where there are none, the ones a folder further down.

    Raises:
        InputError: a folder cannot be read, or neither is nor holds a run.
    """
    found: dict[Path, None] = {}
    mend = "give the --out folder of a run"
    for folder in folders:
        try:
            if not is_folder(folder):
                raise InputError(str(folder), "is no folder", mend)
            runs = [folder] if is_run(folder) else _runs_below(folder) or _runs_further_down(folder)
        except OSError as error:
            raise InputError(str(folder), f"cannot be read ({error.strerror})", mend) from error
        if not runs:
            raise InputError(str(folder), "neither is nor holds a run folder", mend)
        found |= dict.fromkeys(runs)
    return list(found)


def new_folder(field: str, folder: Path) -> None:
    """Make a folder, or see that it is empty.

    Raises:
        InputError: it holds something, is a file, or cannot be made.
    """
    with refuse_unwritable(field, folder):
        if is_there(folder) and (not is_folder(folder) or any(folder.iterdir())):
            raise InputError(field, f"{folder} is not empty", "use a new or empty folder")
        folder.mkdir(parents=True, exist_ok=True)


def is_run(folder: Path) -> bool:
    """Whether it is a folder of a run, or of what `gsiirl theory` found."""
    return any(is_file(folder / name) for name in ("config.json", "theory.json"))


def _runs_below(folder: Path) -> list[Path]:
    return sorted(below for below in folder.iterdir() if is_run(below))


def _runs_further_down(folder: Path) -> list[Path]:
    return [run for below in sorted(folder.iterdir()) if is_folder(below) for run in _runs_below(below)]
