"""The checksum that a file carries in itself.

A list of checksums beside the files would have to be in step with them at every moment, also when a process is killed
or the machine stops between two writes. A file that carries its own is replaced together with it: whatever happens, it
is the old one or the new one, and either is whole. What no checksum tells, that a file is missing, is told by those
that name it: `summary.json` lists the files of a finished run, and chunks are numbered.
"""

import re
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path

from gsiirl.errors import InputError, InputWarning, warn

NAME = "checksum"
"""The key under which JSON and the metadata of safetensors and Parquet hold it, before any text of a user's."""
PLACE = "gsiirl-sha256:" + 64 * "0"
"""What stands in its place while it is computed."""

_PLACE = PLACE.encode()
_CARRIED = re.compile(rb"gsiirl-sha256:[0-9a-f]{64}")


def sealed(content: bytes) -> bytes:
    """`content` with the checksum of all of it in place of the first `PLACE`."""
    return content.replace(_PLACE, b"gsiirl-sha256:" + sha256(content).hexdigest().encode(), 1)


def is_checksum(value: object) -> bool:
    """Whether a value that was read is a checksum."""
    return isinstance(value, str) and _CARRIED.fullmatch(value.encode()) is not None


def is_intact(content: bytes) -> bool | None:
    """Whether `content` is as it was sealed; None where it carries no checksum."""
    carried = _CARRIED.search(content)
    return None if carried is None else sealed(_CARRIED.sub(_PLACE, content, count=1)) == content


def read_intact(path: Path, mend: str, carries: bool = False) -> bytes:
    """The bytes of `path`, whose checksum is right; if it `carries` one, which files of earlier versions do not.

    Raises:
        InputError: it cannot be read, or is not as it was written; `mend` says what to do about it.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", mend) from error
    intact = is_intact(content)
    if intact is False:
        raise InputError(str(path), "is damaged: its content is not what its checksum says", mend)
    if intact is None and carries:
        raise InputError(str(path), "is damaged: its checksum is gone", mend)
    return content


def carries_checksum(content: Mapping[str, object], folder: Path) -> bool:
    """Whether what was read from the JSON of a folder carries a checksum; an `InputWarning` says so if it does not."""
    if NAME not in content:
        told = f"{folder} was written before files carried checksums: damage to it may go unseen"
        warn(told, InputWarning)
    return NAME in content
