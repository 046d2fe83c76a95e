"""Metrics are written chunk by chunk and read as one table."""

from pathlib import Path

import numpy as np
import polars
import pytest

from gsiirl.errors import InputError
from gsiirl.runs import RunFolder, summarise


@pytest.fixture
def run(tmp_path: Path) -> RunFolder:
    return RunFolder.create(tmp_path / "run", {"experiment": "security", "algorithm": "gsiirl"}, {})


def chunk(iterations: range, seeds: int = 2) -> dict[str, np.ndarray]:
    # Iteration by iteration, as a scan over seeds under vmap gives them.
    iteration, seed = np.meshgrid(np.array(iterations), np.arange(seeds), indexing="ij")
    return {
        "seed": seed.ravel(),
        "iteration": iteration.ravel(),
        "nash_gap": (iteration + 0.1 * seed).ravel().astype(np.float32),
    }


def test_chunks_come_back_as_one_table_sorted_by_seed_and_iteration(run: RunFolder) -> None:
    run.append_metrics(0, chunk(range(0, 3)))
    run.append_metrics(1, chunk(range(3, 5)))
    metrics = run.metrics()
    assert metrics["seed"].to_list() == [0] * 5 + [1] * 5
    assert metrics["iteration"].to_list() == [0, 1, 2, 3, 4] * 2
    assert metrics.schema == {"seed": polars.Int64, "iteration": polars.Int64, "nash_gap": polars.Float64}


def test_only_the_first_chunks_are_read_when_their_number_is_given(run: RunFolder) -> None:
    run.append_metrics(0, chunk(range(0, 3)))
    run.append_metrics(1, chunk(range(3, 5)))
    assert run.metrics(chunks=1)["iteration"].to_list() == [0, 1, 2] * 2
    assert run.metrics(chunks=0).columns == ["seed", "iteration"]


def test_a_chunk_written_anew_replaces_the_old_one(run: RunFolder) -> None:
    run.append_metrics(0, chunk(range(0, 3)))
    run.append_metrics(0, chunk(range(0, 2)))
    assert run.metrics()["iteration"].to_list() == [0, 1] * 2


def test_the_same_metrics_give_the_same_bytes(run: RunFolder) -> None:
    run.append_metrics(0, chunk(range(0, 300), seeds=10))
    run.append_metrics(1, chunk(range(0, 300), seeds=10))
    first, second = sorted((run.path / "metrics").iterdir())
    assert first.read_bytes() == second.read_bytes()


def test_nan_survives(run: RunFolder) -> None:
    run.append_metrics(0, {**chunk(range(0, 1)), "nash_gap": np.array([np.nan, np.inf])})
    values = run.metrics()["nash_gap"].to_numpy()
    np.testing.assert_array_equal(values, [np.nan, np.inf])


def test_no_chunks_give_an_empty_table(run: RunFolder) -> None:
    assert run.metrics().shape == (0, 2)


def test_metrics_without_their_keys_are_refused(run: RunFolder) -> None:
    with pytest.raises(ValueError, match="iteration missing"):
        run.append_metrics(0, {"seed": np.array([0])})


def test_a_missing_chunk_is_named(run: RunFolder) -> None:
    run.append_metrics(0, chunk(range(0, 3)))
    with pytest.raises(InputError, match=r"chunk-00001.parquet: is missing"):
        run.metrics(chunks=2)
    run.append_metrics(2, chunk(range(3, 6)))
    with pytest.raises(InputError, match=r"chunk-00001.parquet: is missing"):
        run.metrics()


@pytest.mark.parametrize("damage", [b"", b"PAR1", b"not a table at all, but long enough to look like one"])
def test_a_damaged_chunk_is_named_in_one_line(run: RunFolder, damage: bytes) -> None:
    run.append_metrics(0, chunk(range(0, 3)))
    (run.path / "metrics" / "chunk-00000.parquet").write_bytes(damage)
    with pytest.raises(InputError, match=r"chunk-00000.parquet: is damaged") as error:
        run.metrics()
    assert "\n" not in str(error.value)


def test_a_cut_off_chunk_is_named(run: RunFolder) -> None:
    run.append_metrics(0, chunk(range(0, 30)))
    path = run.path / "metrics" / "chunk-00000.parquet"
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(InputError, match="is damaged"):
        run.metrics()


def test_chunks_with_different_columns_are_damaged(run: RunFolder) -> None:
    run.append_metrics(0, chunk(range(0, 3)))
    run.append_metrics(1, {**chunk(range(3, 5)), "feature_gap": np.zeros(4)})
    with pytest.raises(InputError, match="columns are not those of the other chunks"):
        run.metrics()


@pytest.mark.parametrize(
    "rows",
    [
        [(0, 0), (0, 1), (1, 0)],
        [(0, 0), (0, 1), (1, 0), (1, 2)],
        [(0, 0), (0, 0), (1, 0), (1, 1)],
        [(0, 1), (0, 2), (1, 1), (1, 2)],
    ],
)
def test_a_lacking_iteration_of_a_seed_is_damage(run: RunFolder, rows: list[tuple[int, int]]) -> None:
    seed, iteration = np.array(rows).T
    run.append_metrics(0, {"seed": seed, "iteration": iteration})
    with pytest.raises(InputError, match="lacks an iteration of a seed, or has one twice"):
        run.metrics()


def test_copies_of_chunks_are_no_chunks(run: RunFolder) -> None:
    run.append_metrics(0, chunk(range(0, 3)))
    (run.path / "metrics" / "chunk-00000 (copy).parquet").write_bytes(b"")
    assert len(run.metrics()) == 6


def test_a_summary_of_other_metrics_is_damage(run: RunFolder) -> None:
    run.append_metrics(0, chunk(range(0, 3)))
    summary = summarise(run.config, run.metrics(), completed=True)
    run.write_summary(summary)
    assert len(run.metrics()) == 6
    run.append_metrics(0, chunk(range(0, 2)))
    with pytest.raises(InputError, match=r"summary.json: is damaged .*not of the seeds and iterations of the metrics"):
        run.metrics()
    run.append_metrics(0, {**chunk(range(0, 3)), "nash_gap": np.zeros(6)})
    with pytest.raises(InputError, match=r"summary.json: is damaged .*final.nash_gap is not what the metrics say"):
        run.metrics()
