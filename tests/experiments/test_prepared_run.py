"""The runner with an experiment that is no game: whatever keeps to `PreparedRun` is run, cut and gone on with."""

import errno
import os
from dataclasses import replace
from pathlib import Path

import jax
import jax.numpy as jnp
import polars
import pytest
from jaxtyping import Array, PRNGKeyArray, PyTree

from gsiirl.errors import InputError
from gsiirl.experiments import runner
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.prepared_run import Algorithm, Ending, Parameters, PreparedRun, Record
from gsiirl.runs import RunFolder, lock, locked

CONFIG = CrossingConfig(seeds=3, first_seed=4, iterations=7)


def walk(config: CrossingConfig, saved_game: Path | None) -> PreparedRun:
    """A random walk, which keeps its random key in its state."""

    def observe(state: PyTree) -> Record:
        return {"position": state["position"], "distance": jnp.abs(state["position"])}

    def advance(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        def one_step(state: PyTree, iteration: Array) -> tuple[PyTree, Record]:
            own, step_key = jax.random.split(state["key"])
            step = jax.random.normal(step_key) + jax.random.normal(jax.random.fold_in(key, iteration))
            return {"key": own, "position": state["position"] + step}, observe(state)

        return jax.lax.scan(one_step, state, first + jnp.arange(number))

    def finish(state: PyTree, key: PRNGKeyArray) -> Ending:
        places = jnp.linspace(0.0, 1.0, 4, dtype=jnp.float32)
        return Ending(
            record=observe(state),
            paths={"x": state["position"] + jax.random.normal(key, (2, 5)), "goal": jnp.zeros((2, 5), jnp.int32)},
            learned={"expert_reward": jnp.stack([state["position"], -state["position"]])},
            reward_map={"x": places, "y": -places, "learned": places * state["position"], "true": places},
            policies={"learner.layers.0.weight": state["position"] * jnp.ones((2, 3), jnp.float32)},
        )

    return PreparedRun(
        game={"name": "walk"},
        algorithm=Algorithm(
            lambda key: {"key": key, "position": jax.random.normal(key, dtype=jnp.float32)}, advance, finish
        ),
        iterations=config.iterations,
        chunk=3,
        references=lambda: {"constant": jnp.asarray(2.5)},
        parameters={"expert_reward": Parameters(2.0, ("forth", "back"))},
    )


@pytest.fixture(autouse=True)
def _walk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "_prepare", walk)


@pytest.fixture
def finished(tmp_path: Path) -> Path:
    runner.run(CONFIG, tmp_path / "whole")
    return tmp_path / "whole"


def bytes_of(folder: Path) -> dict[str, bytes]:
    """Everything but how long it took, and a state that nobody reads again."""
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != "environment.json"]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_every_part_of_the_ending_is_kept(finished: Path):
    folder = RunFolder.open(finished)
    assert (folder.config["experiment"], folder.game["name"]) == ("crossing", "walk")
    metrics = folder.metrics()
    assert metrics["seed"].to_list() == [seed for seed in (4, 5, 6) for _ in range(8)]
    assert metrics["iteration"].to_list() == [*range(8)] * 3
    assert set(metrics["constant"]) == {2.5}
    paths = folder.paths()
    assert paths is not None
    assert paths.columns[:3] == ["seed", "trajectory", "step"]
    assert (paths.schema["x"], paths.schema["goal"]) == (polars.Float64, polars.Int64)
    assert paths["step"].to_list() == [*range(5)] * 6
    reward_map = folder.reward_map()
    assert reward_map is not None
    assert set(reward_map.columns) == {"seed", "x", "y", "learned", "true"}
    assert reward_map["seed"].to_list() == [seed for seed in (4, 5, 6) for _ in range(4)]
    learned = folder.load_learned()
    assert learned is not None
    assert learned.arrays["expert_reward"].dtype == "float32"
    last = metrics.filter(polars.col("iteration") == 7)["position"]
    assert learned.weights("expert_reward")[:, 0].tolist() == (2.0 * last).to_list()
    policies = folder.load_policies()
    assert policies is not None
    assert policies["learner.layers.0.weight"].shape == (3, 2, 3)
    assert policies["learner.layers.0.weight"][:, 0, 0].tolist() == last.to_list()


@pytest.mark.parametrize("stop_after", [0, 1, 2, 3])
def test_a_run_cut_anywhere_resumes_to_identical_bytes(finished, tmp_path, monkeypatch, stop_after: int):
    saved: list[int] = []
    append = RunFolder.append_metrics

    def append_and_stop(folder: RunFolder, chunk: int, *arguments: object) -> None:
        append(folder, chunk, *arguments)  # pyright: ignore[reportArgumentType]
        if chunk == stop_after:
            raise KeyboardInterrupt
        saved.append(chunk)

    monkeypatch.setattr(RunFolder, "append_metrics", append_and_stop)
    with pytest.raises(KeyboardInterrupt):
        runner.run(CONFIG, tmp_path / "cut")
    assert saved == [*range(stop_after)]
    monkeypatch.setattr(RunFolder, "append_metrics", append)
    runner.resume(tmp_path / "cut")
    assert bytes_of(tmp_path / "cut") == bytes_of(finished)


@pytest.mark.parametrize("number", [1, 3])
def test_diverging_seeds_are_named_and_the_run_ends(finished, monkeypatch, tmp_path, number: int):
    starts = RunFolder.open(finished).metrics().filter(polars.col("iteration") == 0).sort("position")
    diverging, bound = sorted(starts["seed"][:number]), starts["position"][number - 1]

    def divergent(config: CrossingConfig, saved_game: Path | None) -> PreparedRun:
        whole = walk(config, saved_game)

        def init(key: PRNGKeyArray) -> PyTree:
            state = whole.algorithm.init(key)
            return state | {"position": jnp.where(state["position"] <= bound, jnp.nan, state["position"])}

        return replace(whole, algorithm=replace(whole.algorithm, init=init))

    monkeypatch.setattr(runner, "_prepare", divergent)
    runner.run(CONFIG, tmp_path / "run")
    summary = RunFolder.open(tmp_path / "run").summary()
    assert summary is not None
    assert (summary.completed, summary.failed_seeds) == (True, diverging)
    assert bool(summary.final) == (number < 3)


def test_a_checkpoint_of_another_shape_is_refused(finished, monkeypatch):
    (finished / "summary.json").unlink()
    folder = RunFolder.open(finished)
    checkpoint = folder.load_checkpoint()
    assert checkpoint is not None
    for change in (lambda array: array[:2], lambda array: array.astype("float64")):
        arrays = {name: change(array) for name, array in checkpoint.arrays.items()}
        folder.save_checkpoint(arrays, checkpoint.iteration, checkpoint.chunks)
        with pytest.raises(InputError, match=r"checkpoint: holds .* as .* of shape"):
            runner.resume(finished)
    folder.save_checkpoint({}, checkpoint.iteration, checkpoint.chunks)
    with pytest.raises(InputError, match="checkpoint: holds no "):
        runner.resume(finished)


def test_the_experiment_chooses_the_precision(finished, monkeypatch, tmp_path):
    precisions: list[bool] = []

    def note(config: CrossingConfig, saved_game: Path | None) -> PreparedRun:
        precisions.append(jax.config.jax_enable_x64)  # pyright: ignore[reportAttributeAccessIssue]
        raise InputError("a", "b", "c")

    monkeypatch.setattr(runner, "_prepare", note)
    with pytest.raises(InputError):
        runner.run(CONFIG, tmp_path / "single")
    assert not (tmp_path / "single").exists()
    assert precisions == [False]


@pytest.mark.parametrize("wrong", [float("nan"), float("inf")])
def test_a_game_that_cannot_be_solved_stops_the_run_before_it_has_a_folder(
    wrong: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def prepare(config: CrossingConfig, saved_game: Path | None) -> PreparedRun:
        prepared = walk(config, saved_game)
        return replace(prepared, references=lambda: {"constant": jnp.asarray(1.0), "truth": jnp.asarray(wrong)})

    monkeypatch.setattr(runner, "_prepare", prepare)
    with pytest.raises(InputError, match=f"crossing: the game cannot be solved: truth is {wrong}; give a temperature"):
        runner.run(CONFIG, tmp_path / "run")
    assert not (tmp_path / "run").exists()


def full(*_: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("method", ["append_metrics", "save_checkpoint", "save_policies", "write_summary"])
def test_a_disk_that_fills_up_is_told_and_the_run_goes_on_when_there_is_room(
    finished, tmp_path, monkeypatch, method: str
):
    with monkeypatch.context() as disk:
        disk.setattr(RunFolder, method, full)
        with pytest.raises(InputError) as error:
            runner.run(CONFIG, tmp_path / "cut")
    cut = tmp_path / "cut"
    problem = f"{cut}: cannot be written (No space left on device); make room or allow it"
    assert str(error.value) == f"{problem}, then go on with `gsiirl resume {cut}`"
    runner.resume(cut)
    assert bytes_of(cut) == bytes_of(finished)


def test_two_processes_do_not_work_in_one_folder(finished, tmp_path, monkeypatch):
    monkeypatch.setattr(lock, "PATIENCE", 0.05)
    before = bytes_of(finished)
    with locked(finished, "--out"):
        # One that is finished has nothing to be kept from.
        runner.resume(finished)
        assert (finished / lock.LOCK).exists()
        (finished / "summary.json").unlink()
        with pytest.raises(InputError, match="is in use by another process"):
            runner.resume(finished)
    runner.resume(finished)
    assert bytes_of(finished) == before
    (finished / lock.LOCK).touch()
    runner.resume(finished)
    assert bytes_of(finished) == before
    with locked(tmp_path / "new", "--out"), pytest.raises(InputError, match="is in use by another process"):
        runner.run(CONFIG, tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(("iteration", "chunks"), [(6, 1), (3, 2), (9, 3), (99, 2)])
def test_a_checkpoint_that_the_metrics_do_not_reach_is_refused(finished, iteration: int, chunks: int):
    (finished / "summary.json").unlink()
    folder = RunFolder.open(finished)
    checkpoint = folder.load_checkpoint()
    assert checkpoint is not None
    folder.save_checkpoint(checkpoint.arrays, iteration, chunks)
    with pytest.raises(InputError, match=r"does not hold|is of iteration"):
        runner.resume(finished)


def test_a_missing_chunk_before_a_checkpoint_is_told_before_the_run_goes_on(finished):
    (finished / "summary.json").unlink()
    (finished / "metrics" / "chunk-00001.parquet").unlink()
    with pytest.raises(InputError, match=r"chunk-00001.parquet: is missing"):
        runner.resume(finished)


def test_a_folder_that_cannot_be_used_is_told_before_anything_is_prepared(finished, monkeypatch, tmp_path):
    monkeypatch.setattr(runner, "_prepare", full)
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="holds other files"):
        runner.run(CONFIG, tmp_path / "notes")
    with pytest.raises(InputError, match="holds another run"):
        runner.run(replace(CONFIG, seeds=2), finished)


def test_a_folder_that_holds_the_same_run_is_told_before_the_game_is_solved(finished, monkeypatch):
    monkeypatch.setattr(runner, "_references", full)
    with pytest.raises(InputError, match="holds this run already"):
        runner.run(CONFIG, finished)


def test_more_seeds_than_the_memory_holds_are_refused_before_there_is_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    # A walk's state is a key and a position, 12 bytes a seed, and four copies of them.
    monkeypatch.setattr(runner, "available_memory", lambda: 300)
    with pytest.raises(InputError, match=r"--seeds: 4 take 0\.0 GB of memory, .*; use at most 3$"):
        runner.run(replace(CONFIG, seeds=4), tmp_path / "run")
    assert not (tmp_path / "run").exists()
    runner.run(replace(CONFIG, seeds=3), tmp_path / "run")
