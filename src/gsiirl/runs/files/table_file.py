"""One table in one Parquet file."""

import io
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import polars
from polars.datatypes import DataTypeClass

from gsiirl.errors import InputError
from gsiirl.runs.files.atomic import write_atomically
from gsiirl.runs.files.checksum import NAME, PLACE, read_intact, sealed


def write_table(path: Path, columns: Mapping[str, np.ndarray], types: Mapping[str, DataTypeClass]) -> None:
    """Write the columns, each of shape [rows], as the given types; the same columns give the same bytes."""
    table = polars.DataFrame([polars.Series(name, np.asarray(columns[name])).cast(types[name]) for name in columns])
    stream = io.BytesIO()
    table.write_parquet(stream, metadata={NAME: PLACE})
    write_atomically(path, sealed(stream.getvalue()))


def read_table(path: Path, mend: str, carries: bool = False) -> polars.DataFrame:
    """The table in `path`; every column holds numbers (or truth values), in every row. See `read_intact` for `carries`.

    Raises:
        InputError: missing or damaged; `mend` says what to do about it.
    """
    content = read_intact(path, mend, carries)
    try:
        with _unheard():
            table = polars.read_parquet(content)
    except (polars.exceptions.PolarsError, polars.exceptions.PanicException) as error:
        raise InputError(str(path), f"is damaged: no valid Parquet ({str(error)[:100]})", mend) from error
    for column in table:
        if not (column.dtype.is_numeric() or column.dtype == polars.Boolean) or column.null_count():
            problem = f"is damaged: {column.name} holds {column.dtype}, or lacks a value"
            raise InputError(str(path), problem, mend)
    return table


@contextmanager
def _unheard() -> Iterator[None]:
    """Leave out what Rust itself writes to the standard error when a reader panics: the error is told in one line."""
    heard = os.dup(2)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(heard, 2)
        os.close(heard)
