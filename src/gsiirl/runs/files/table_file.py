"""One table in one Parquet file."""

import io
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import polars
from polars.datatypes import DataTypeClass

from gsiirl.errors import InputError
from gsiirl.runs.files.atomic import write_atomically
from gsiirl.runs.files.checksum import NAME, PLACE, is_intact, read_intact, sealed

LONGEST = 60.0
"""Seconds that the tables of an earlier version may take to be read."""


def write_table(path: Path, columns: Mapping[str, np.ndarray], types: Mapping[str, DataTypeClass]) -> None:
    """Write the columns, each of shape [rows], as the given types; the same columns give the same bytes."""
    table = polars.DataFrame([polars.Series(name, np.asarray(columns[name])).cast(types[name]) for name in columns])
    stream = io.BytesIO()
    table.write_parquet(stream, metadata={NAME: PLACE})
    write_atomically(path, sealed(stream.getvalue()))


def read_table(path: Path, mend: str, carries: bool = False) -> polars.DataFrame:
    """The table in `path`; see `read_tables`."""
    return read_tables([path], mend, carries)[0]


def read_tables(paths: Sequence[Path], mend: str, carries: bool = False) -> list[polars.DataFrame]:
    """The tables in `paths`; every column holds numbers or truth values, in every row. See `read_intact` for `carries`.

    Raises:
        InputError: one is missing or damaged; `mend` says what to do about it.
    """
    contents = [read_intact(path, mend, carries) for path in paths]
    sealed_ones = all(is_intact(content) for content in contents)
    tables = _parsed(paths, contents, mend) if sealed_ones else _read_apart(paths, mend)
    for path, table in zip(paths, tables, strict=True):
        for column in table:
            if not (column.dtype.is_numeric() or column.dtype == polars.Boolean) or column.null_count():
                raise _damaged(path, f"{column.name} holds {column.dtype}, or lacks a value", mend)
    return tables


def _parsed(paths: Sequence[Path], contents: Sequence[bytes], mend: str) -> list[polars.DataFrame]:
    tables: list[polars.DataFrame] = []
    for path, content in zip(paths, contents, strict=True):
        try:
            tables.append(polars.read_parquet(content))
        except (polars.exceptions.PolarsError, polars.exceptions.PanicException) as error:
            raise _damaged(path, "no valid Parquet", mend) from error
    return tables


READING = """
import io, sys, polars
for path in sys.argv[1:]:
    stream = io.BytesIO()
    polars.read_parquet(path).write_ipc(stream)
    sys.stdout.buffer.write(stream.tell().to_bytes(8, "little") + stream.getvalue())
    sys.stdout.flush()
"""


def _read_apart(paths: Sequence[Path], mend: str) -> list[polars.DataFrame]:
    """Tables that carry no checksum, read by another process: at some damage the reader of Parquet ends its own."""
    command = [sys.executable, "-c", READING, *map(str, paths)]
    try:
        told = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, timeout=LONGEST).stdout
    except subprocess.TimeoutExpired as error:
        told = error.stdout or b""
    tables: list[polars.DataFrame] = []
    for path in paths:
        end = 8 + int.from_bytes(told[:8], "little")
        if not 8 < end <= len(told):
            raise _damaged(path, "no valid Parquet", mend)
        tables.append(polars.read_ipc(told[8:end]))
        told = told[end:]
    return tables


def _damaged(path: Path, problem: str, mend: str) -> InputError:
    return InputError(str(path), f"is damaged: {problem}", mend)
