"""Writing a file so that a reader sees the old content or the new one, never a part."""

import os
from pathlib import Path


def write_atomically(path: Path, content: bytes) -> None:
    """Write `content` aside, force it to the disk, then rename it over `path`; parent folders are made.

    Raises:
        OSError: the content could not be written; what stood at `path` before still stands there.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(path.name + ".aside")
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
