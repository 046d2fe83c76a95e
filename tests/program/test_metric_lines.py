import json
from pathlib import Path

import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.program.metric_lines import SCREEN, metric_lines

COLUMNS = {"seed": np.array([0, 1]), "iteration": np.array([3, 3]), "regret": np.array([0.25, np.nan])}
ROWS = [{"seed": 0, "iteration": 3, "regret": 0.25}, {"seed": 1, "iteration": 3, "regret": None}]


def test_rows_are_appended_and_written_through_at_once(tmp_path: Path):
    file = tmp_path / "rows.jsonl"
    file.write_text('{"mine": 1}\n')
    with metric_lines(file) as write:
        assert write is not None
        write(COLUMNS)
        assert [json.loads(line) for line in file.read_text().splitlines()] == [{"mine": 1}, *ROWS]


def test_a_dash_is_the_screen(capsys: pytest.CaptureFixture[str]):
    with metric_lines(SCREEN) as write:
        assert write is not None
        write(COLUMNS)
    assert [json.loads(line) for line in capsys.readouterr().out.splitlines()] == ROWS


def test_without_a_file_nobody_is_told():
    with metric_lines(None) as write:
        assert write is None


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path):
    with (
        pytest.raises(InputError, match=r"--metrics-to: .* cannot be written .*; give another file"),
        metric_lines(tmp_path),
    ):
        pass


def test_a_full_disk_is_said_in_one_line():
    def fill() -> None:
        with metric_lines(Path("/dev/full")) as write:
            assert write is not None
            write(COLUMNS)

    with pytest.raises(InputError, match="--metrics-to: /dev/full cannot be written"):
        fill()
