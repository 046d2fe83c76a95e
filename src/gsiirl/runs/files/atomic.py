"""Writing a file so that a reader sees the old content or the new one, never a part."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gsiirl.errors import InputError

ASIDE = ".aside"
"""Ending of the copy that is being written."""


def write_atomically(path: Path, content: bytes) -> None:
    """Write `content` aside, force it to the disk, then rename it over `path`; parent folders are made.

    Raises:
        OSError: the content could not be written; what stood at `path` before still stands there.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(path.name + ASIDE)
    try:
        with aside.open("wb") as stream:
            stream.write(content)
            stream.flush()
            # Without it a power cut could leave the new name on an empty file.
            os.fsync(stream.fileno())
        os.replace(aside, path)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


@contextmanager
def refuse_unwritable(
    field: str, folder: Path, mend: str = "make room or allow it, or use another folder"
) -> Iterator[None]:
    """Turn a failure to write into `folder` into an error that says so.

    Raises:
        InputError: the disk is full or read-only, the user may not write there, or the like.
    """
    try:
        yield
    except OSError as error:
        what = "" if field == str(folder) else f"{folder} "
        raise InputError(field, f"{what}cannot be written ({error.strerror or error})", mend) from error
