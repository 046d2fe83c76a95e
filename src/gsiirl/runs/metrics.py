"""The metrics of a run: one Parquet file a chunk of iterations, one row a seed and iteration."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.files.table_file import read_table, write_table

KEY_COLUMNS = ("seed", "iteration")


def append_chunk(folder: Path, chunk: int, columns: Mapping[str, np.ndarray]) -> None:
    """Write (or write anew) chunk number `chunk`; every column has one value a row.

    Raises:
        ValueError: `seed` or `iteration` is missing.
    """
    missing = [name for name in KEY_COLUMNS if name not in columns]
    if missing:
        raise ValueError(f"metrics need the columns {', '.join(KEY_COLUMNS)}: {', '.join(missing)} missing")
    types = {name: polars.Int64 if name in KEY_COLUMNS else polars.Float64 for name in columns}
    write_table(_chunk_path(folder, chunk), columns, types)


def read_chunks(folder: Path, chunks: int | None = None) -> polars.DataFrame:
    """All metrics, or those of the first `chunks` chunks, sorted by seed and iteration.

    Raises:
        InputError: a chunk is missing or damaged.
    """
    if chunks is None:
        paths = sorted(folder.glob("chunk-*.parquet"))
    else:
        paths = [_chunk_path(folder, chunk) for chunk in range(chunks)]
    tables = [read_table(path, START_AGAIN) for path in paths]
    for path, table in zip(paths, tables, strict=True):
        if table.schema != tables[0].schema or not set(KEY_COLUMNS) <= set(table.columns):
            raise InputError(str(path), "is damaged: its columns are not those of the other chunks", START_AGAIN)
    if not tables:
        return polars.DataFrame(schema=dict.fromkeys(KEY_COLUMNS, polars.Int64))
    return polars.concat(tables).sort(KEY_COLUMNS)


def _chunk_path(folder: Path, chunk: int) -> Path:
    return folder / f"chunk-{chunk:05d}.parquet"
