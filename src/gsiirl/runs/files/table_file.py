"""One table in one Parquet file."""

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import polars
from polars.datatypes import DataTypeClass

from gsiirl.errors import InputError
from gsiirl.runs.files.atomic import write_atomically


def write_table(path: Path, columns: Mapping[str, np.ndarray], types: Mapping[str, DataTypeClass]) -> None:
    """Write the columns, each of shape [rows], as the given types; the same columns give the same bytes."""
    table = polars.DataFrame([polars.Series(name, np.asarray(columns[name])).cast(types[name]) for name in columns])
    stream = io.BytesIO()
    table.write_parquet(stream)
    write_atomically(path, stream.getvalue())


def read_table(path: Path, mend: str) -> polars.DataFrame:
    """The table in `path`.

    Raises:
        InputError: missing or damaged; `mend` says what to do about it.
    """
    try:
        return polars.read_parquet(path.read_bytes())
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", mend) from error
    except polars.exceptions.PolarsError as error:
        raise InputError(str(path), f"is damaged: no valid Parquet ({error})", mend) from error
