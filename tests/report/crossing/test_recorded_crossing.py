"""A damaged description of the crossing is named."""

from pathlib import Path

import pytest
from report.synthetic_plane import write_plane_run
from resealing import rewrite

from gsiirl.errors import InputError
from gsiirl.report import build_report


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("game.json", '"safe_distance"', '"distance"'),
        ("game.json", '"goal_radius": 0.05', '"goal_radius": "wide"'),
        ("game.json", '"robot_goal": [', '"robot_goal": [0, '),
    ],
)
def test_a_damaged_game_is_named_in_one_line(tmp_path: Path, name: str, old: str, new: str) -> None:
    write_plane_run(tmp_path / "run", "crossing", "marl", seeds=1)
    path = tmp_path / "run" / name
    rewrite(path, old, new)
    with pytest.raises(InputError, match=f"{name}: is damaged") as error:
        build_report([tmp_path / "run"], tmp_path / "out")
    assert "\n" not in str(error.value)
