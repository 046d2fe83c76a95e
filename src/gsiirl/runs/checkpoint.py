"""The checkpoint from which an interrupted run goes on."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gsiirl.errors import InputError
from gsiirl.program.presence import is_there
from gsiirl.runs.files.array_file import read_versioned_arrays, write_arrays
from gsiirl.runs.files.json_file import FORMAT_VERSION

MEND = "delete it, and gsiirl resume starts this run from its first iteration"


@dataclass(frozen=True)
class Checkpoint:
    """State of a run after an iteration."""

    arrays: dict[str, np.ndarray]
    """The state, by name."""
    iteration: int
    """Last iteration done."""
    chunks: int
    """Metrics chunks that were complete by then; later ones do not belong to this state."""


def write_checkpoint(path: Path, arrays: Mapping[str, np.ndarray], iteration: int, chunks: int) -> None:
    """Replace the checkpoint at `path`."""
    metadata = {"format_version": FORMAT_VERSION, "iteration": iteration, "chunks": chunks}
    write_arrays(path, arrays, {name: str(value) for name, value in metadata.items()})


def read_checkpoint(path: Path, carries: bool = False) -> Checkpoint | None:
    """The checkpoint at `path`, or None where none was written yet.

    Raises:
        InputError: it is damaged or of an unknown format.
    """
    if not is_there(path):
        return None
    arrays, metadata = read_versioned_arrays(path, MEND, carries)
    numbers = [metadata.get(name, "") for name in ("iteration", "chunks")]
    if not all(re.fullmatch("[0-9]{1,9}", number) for number in numbers):
        raise InputError(str(path), "is damaged: it names no iteration or chunks", MEND)
    return Checkpoint(arrays, *map(int, numbers))
