"""Tables of earlier versions carry no checksum, so a damaged one meets the reader of Parquet."""

from datetime import date
from pathlib import Path

import polars
import pytest

from gsiirl.errors import InputError
from gsiirl.runs.files import table_file
from gsiirl.runs.files.table_file import read_table, read_tables

PANICS = sorted((Path(__file__).parents[2] / "data" / "run_folders").glob("*.parquet"))


@pytest.mark.parametrize("path", PANICS, ids=lambda path: path.stem)
def test_a_file_at_which_the_reader_panics_gets_one_line_and_nothing_else(
    path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(InputError, match=r"parquet: is damaged: no valid Parquet; mend it$") as error:
        read_table(path, "mend it")
    assert "\n" not in str(error.value)
    assert capfd.readouterr() == ("", "")


def test_there_is_such_a_file() -> None:
    assert len(PANICS) == 3


@pytest.mark.parametrize("column", [["a"], [1, None], [[1]], [date(2020, 1, 1)]])
def test_a_column_that_holds_no_numbers_or_lacks_one_is_damage(tmp_path: Path, column: list[object]) -> None:
    polars.DataFrame({"x": column}).write_parquet(tmp_path / "table.parquet")
    with pytest.raises(InputError, match=r"is damaged: x holds .*, or lacks a value"):
        read_table(tmp_path / "table.parquet", "mend it")


def test_of_several_the_damaged_one_is_named(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("a", "b", "c")]
    for number, path in enumerate(paths):
        polars.DataFrame({"x": [number]}).write_parquet(path)
    assert [table["x"].to_list() for table in read_tables(paths, "mend it")] == [[0], [1], [2]]
    paths[1].write_bytes(PANICS[0].read_bytes())
    with pytest.raises(InputError, match=r"b: is damaged: no valid Parquet; mend it"):
        read_tables(paths, "mend it")


def test_a_reader_that_does_not_end_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table_file, "LONGEST", 0.2)
    monkeypatch.setattr(table_file, "READING", "import time; time.sleep(60)")
    with pytest.raises(InputError, match=r"parquet: is damaged: no valid Parquet; mend it"):
        read_table(PANICS[0], "mend it")
