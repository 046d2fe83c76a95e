"""Damage to the files of a run folder whose checksum is right again, so that what stands behind the checksum is met."""

import re
from pathlib import Path

from gsiirl.runs.files.checksum import PLACE, sealed

CARRIED = re.compile(rb"gsiirl-sha256:[0-9a-f]{64}")


def resealed(content: bytes) -> bytes:
    """`content` with the right checksum in place of the one that it carries, or of `PLACE`."""
    return sealed(CARRIED.sub(PLACE.encode(), content, count=1))


def rewrite(path: Path, old: str, new: str) -> None:
    """Put `new` for every `old`, which must be there."""
    content = path.read_bytes()
    assert old.encode() in content
    path.write_bytes(resealed(content.replace(old.encode(), new.encode())))
