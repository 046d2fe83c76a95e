"""Sample paths and reward maps keep whole numbers whole and others exact."""

from pathlib import Path

import numpy as np
import polars
import pytest

from gsiirl.errors import InputError
from gsiirl.runs import RunFolder

INDEX = {"seed": np.array([0, 0]), "trajectory": np.array([0, 0]), "step": np.array([0, 1])}


@pytest.fixture
def run(tmp_path: Path) -> RunFolder:
    return RunFolder.create(tmp_path / "run", {"experiment": "crossing", "algorithm": "gsiirl"}, {})


def test_places_are_stored_as_floats_and_what_counts_as_integers(run: RunFolder) -> None:
    x = np.array([0.1, 1 / 3], dtype=np.float32)
    run.save_paths({**INDEX, "robot_x": x, "state": np.array([3, 4], dtype=np.uint8)})
    paths = run.paths()
    assert paths is not None
    assert paths.schema == {
        **dict.fromkeys(INDEX, polars.Int64),
        "robot_x": polars.Float64,
        "state": polars.Int64,
    }
    np.testing.assert_array_equal(paths["robot_x"].to_numpy(), x.astype(np.float64))


def test_seeds_and_steps_are_integers_however_they_are_given(run: RunFolder) -> None:
    run.save_paths({name: column.astype(np.float32) for name, column in INDEX.items()})
    paths = run.paths()
    assert paths is not None
    assert set(paths.schema.values()) == {polars.Int64}


def test_a_reward_map_reads_back_and_is_none_before(run: RunFolder) -> None:
    assert run.reward_map() is None
    columns = {"seed": np.array([0, 0]), **{name: np.array([0.0, 0.5]) for name in ("x", "y", "learned", "true")}}
    run.save_reward_map(columns)
    table = run.reward_map()
    assert table is not None
    assert table.schema == {"seed": polars.Int64, **dict.fromkeys(("x", "y", "learned", "true"), polars.Float64)}
    np.testing.assert_array_equal(table["learned"].to_numpy(), [0.0, 0.5])


def test_a_damaged_reward_map_is_named(run: RunFolder) -> None:
    (run.path / "reward_map.parquet").write_bytes(b"nothing")
    with pytest.raises(InputError, match=r"reward_map.parquet: is damaged"):
        run.reward_map()
