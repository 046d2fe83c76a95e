"""Metrics as they come, a line of JSON a row, for whoever watches a run from outside."""

import json
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from gsiirl.errors import InputError

if TYPE_CHECKING:
    import numpy as np

SCREEN = Path("-")
"""In place of a file: standard output."""
FIELD = "--metrics-to"


@contextmanager
def metric_lines(file: Path | None) -> Iterator["Callable[[Mapping[str, np.ndarray]], None] | None"]:
    """Who appends rows to `file`, each written through at once; None where no file is asked for.

    A row is `{"seed": 0, "iteration": 3, "deployed_return_learner": -11.2, ...}`; a number that is not finite is null.

    Raises:
        InputError: the file cannot be written.
    """
    if file is None:
        yield None
        return
    if file == SCREEN:
        yield lambda columns: print(*lines(columns), sep="\n", flush=True)
        return
    try:
        with file.open("a", encoding="utf-8") as opened:

            def write(columns: "Mapping[str, np.ndarray]") -> None:
                try:
                    opened.write("".join(f"{line}\n" for line in lines(columns)))
                    opened.flush()
                except OSError as error:
                    raise _refused(file, error) from error

            yield write
    except OSError as error:
        raise _refused(file, error) from error


def lines(columns: "Mapping[str, np.ndarray]") -> list[str]:
    """Columns of one length as a line of JSON a row."""
    names = list(columns)
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [json.dumps({name: _number(value) for name, value in zip(names, row, strict=True)}) for row in rows]


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _refused(file: Path, error: OSError) -> InputError:
    return InputError(FIELD, f"{file} cannot be written ({error.strerror})", "give another file, or leave it out")
