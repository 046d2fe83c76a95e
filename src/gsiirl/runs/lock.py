"""One process at a time works in a run folder."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from gsiirl.errors import InputError
from gsiirl.program.presence import is_there
from gsiirl.runs.files.atomic import refuse_unwritable

LOCK = ".lock"
"""The file that is locked: empty, in the run folder, and there only while a process works in it or after it was killed.

The lock itself is the kernel's (`flock`), so that it ends with its process, however that ends."""

PATIENCE = 3.0
"""Seconds to wait for a process that is about to end, as the children of a killed one are."""


def clear_lock(folder: Path) -> None:
    """Remove the file that a killed process left, if nobody works in `folder`."""
    if is_there(folder / LOCK):
        with suppress(InputError), locked(folder, ""):
            pass


@contextmanager
def locked(folder: Path, field: str, mend: str = "use another folder") -> Iterator[None]:
    """Keep every other process out of `folder`, which is made if need be; `field` and `mend` are for errors.

    Raises:
        InputError: another process works there, or the folder cannot be written.
    """
    lock = FileLock(folder / LOCK, timeout=PATIENCE)
    with refuse_unwritable(field, folder, mend):
        made = not is_there(folder)
        folder.mkdir(parents=True, exist_ok=True)
        try:
            lock.acquire()
        except Timeout as error:
            what = "" if field == str(folder) else f"{folder} "
            raise InputError(field, f"{what}is in use by another process", "wait until it has ended") from error
    try:
        yield
    finally:
        # While it is still locked: whoever opened it meanwhile sees that it is gone, and makes another.
        with suppress(OSError):
            (folder / LOCK).unlink(missing_ok=True)
            if made:
                # Goes only where nothing came to be in it.
                folder.rmdir()
        lock.release()
