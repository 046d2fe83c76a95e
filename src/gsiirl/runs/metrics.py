"""The metrics of a run: one Parquet file a chunk of iterations, one row a seed and iteration."""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.files.table_file import read_tables, write_table

KEY_COLUMNS = ("seed", "iteration")
_CHUNK = re.compile(r"chunk-\d{5,9}\.parquet")


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


def read_chunks(folder: Path, chunks: int | None = None, carries: bool = False) -> polars.DataFrame:
    """All metrics, or those of the first `chunks` chunks, sorted by seed and iteration.

    Raises:
        InputError: a chunk is missing or damaged, or together they lack an iteration of a seed.
    """
    present = {
        int(path.stem.removeprefix("chunk-")) for path in folder.glob("chunk-*.parquet") if _CHUNK.fullmatch(path.name)
    }
    paths = [_chunk_path(folder, chunk) for chunk in range(max(present, default=-1) + 1 if chunks is None else chunks)]
    for chunk, path in enumerate(paths):
        if chunk not in present:
            raise InputError(str(path), "is missing", START_AGAIN)
    tables = read_tables(paths, START_AGAIN, carries)
    for path, table in zip(paths, tables, strict=True):
        types = {
            name: polars.Int64 if name in KEY_COLUMNS else polars.Float64 for name in (*KEY_COLUMNS, *table.columns)
        }
        if table.schema != tables[0].schema or dict(table.schema) != types:
            raise InputError(str(path), "is damaged: its columns are not those of the other chunks", START_AGAIN)
    if not tables:
        return polars.DataFrame(schema=dict.fromkeys(KEY_COLUMNS, polars.Int64))
    metrics = polars.concat(tables).sort(KEY_COLUMNS)
    seeds, iterations = metrics["seed"].unique().sort().to_numpy(), metrics["iteration"].n_unique()
    places = np.repeat(seeds, iterations), np.tile(np.arange(iterations), len(seeds))
    if not all(np.array_equal(metrics[name], column) for name, column in zip(KEY_COLUMNS, places, strict=True)):
        raise InputError(str(folder), "is damaged: it lacks an iteration of a seed, or has one twice", START_AGAIN)
    return metrics


def _chunk_path(folder: Path, chunk: int) -> Path:
    return folder / f"chunk-{chunk:05d}.parquet"
