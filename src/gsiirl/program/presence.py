"""Whether something stands at a path; what keeps that from being known is an error.

`Path.exists` and its like say no from Python 3.14 on also where a name is too long, or a folder may not be looked into.
"""

import errno
import os
import stat
from pathlib import Path

ABSENT = {errno.ENOENT, errno.ENOTDIR, errno.ELOOP}


def is_there(path: Path) -> bool:
    """Whether there is a file or a folder.

    Raises:
        OSError: the system cannot tell.
    """
    return _mode(path) is not None


def is_folder(path: Path) -> bool:
    """Whether there is a folder.

    Raises:
        OSError: the system cannot tell.
    """
    mode = _mode(path)
    return mode is not None and stat.S_ISDIR(mode)


def is_file(path: Path) -> bool:
    """Whether there is a file.

    Raises:
        OSError: the system cannot tell.
    """
    mode = _mode(path)
    return mode is not None and stat.S_ISREG(mode)


def _mode(path: Path) -> int | None:
    try:
        return os.stat(path).st_mode
    except OSError as error:
        if error.errno in ABSENT:
            return None
        raise
    except ValueError:  # a null byte, which no name has
        return None
