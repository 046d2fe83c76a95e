"""Tables of earlier versions carry no checksum, so a damaged one meets the reader of Parquet."""

import io
from pathlib import Path

import polars
import pytest

from gsiirl.errors import InputError
from gsiirl.runs.files.table_file import read_table

PANICS = sorted((Path(__file__).parents[2] / "data" / "run_folders").glob("*panic*"))


@pytest.mark.parametrize("path", PANICS, ids=lambda path: path.stem)
def test_a_file_at_which_the_reader_panics_gets_one_line_and_nothing_else(
    path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(InputError, match=r"parquet: is damaged: no valid Parquet .*; mend it$") as error:
        read_table(path, "mend it")
    assert "\n" not in str(error.value)
    assert capfd.readouterr() == ("", "")


def test_there_is_such_a_file() -> None:
    assert len(PANICS) == 2


@pytest.mark.parametrize("column", [["a"], [1, None], [[1]], [polars.date(2020, 1, 1)]])
def test_a_column_that_holds_no_numbers_or_lacks_one_is_damage(tmp_path: Path, column: list[object]) -> None:
    stream = io.BytesIO()
    polars.select(
        polars.Series("x", column) if not isinstance(column[0], polars.Expr) else column[0].alias("x")
    ).write_parquet(stream)
    (tmp_path / "table.parquet").write_bytes(stream.getvalue())
    with pytest.raises(InputError, match=r"is damaged: x holds .*, or lacks a value"):
        read_table(tmp_path / "table.parquet", "mend it")
