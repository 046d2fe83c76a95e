"""Writing the files of a page."""

from collections.abc import Mapping
from pathlib import Path

from gsiirl.runs.files.atomic import refuse_unwritable, write_atomically


def write_files(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Write contents by file name into `folder`, in their order, each file whole or not at all.

    Raises:
        InputError: `folder` cannot be written.
    """
    with refuse_unwritable("--out", folder):
        for name, content in contents.items():
            write_atomically(folder / name, content)
