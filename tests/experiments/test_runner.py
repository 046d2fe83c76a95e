import json
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import polars
import pytest
from polars.testing import assert_frame_equal
from problems import tiny_config

from gsiirl.experiments import runner
from gsiirl.runs import RunFolder

pytestmark = pytest.mark.usefixtures("optax_promotion")

PROMISED = ("learned.safetensors", "learned.json", "policies.safetensors", "summary.json", "paths.parquet")
"""Besides the metrics, what a resumed run writes byte for byte as the uninterrupted one."""


LEARNERS = {"simple": {"explore": "estimate", "hand_back": "estimate", "starts": "one"}, "default": {}}
"""The runner does not know what learns: quick tests take what compiles soonest."""


TOLD: list[Mapping[str, np.ndarray]] = []
"""What the run `finished` told of itself as it went on."""


def bytes_of(folder: Path) -> dict[str, bytes]:
    files = [*sorted((folder / "metrics").iterdir()), *(folder / name for name in PROMISED)]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Path:
    """A run that nothing interrupts; `halfway`, beside it, is its folder after the first checkpoint."""
    folder = tmp_path_factory.mktemp("runs") / "whole"
    save = RunFolder.save_checkpoint
    TOLD.clear()

    def save_and_copy(run: RunFolder, *arguments: object) -> None:
        save(run, *arguments)  # pyright: ignore[reportArgumentType]
        if not (folder.parent / "halfway").exists():
            shutil.copytree(run.path, folder.parent / "halfway")

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(RunFolder, "save_checkpoint", save_and_copy)
        runner.run(tiny_config(**LEARNERS["simple"]), folder, rows_to=TOLD.append)
    return folder


def test_a_run_leaves_every_file_of_a_run_folder(finished):
    names = {path.name for path in finished.iterdir()}
    assert names == {"config.json", "game.json", "metrics", "checkpoint", "environment.json", *PROMISED}
    summary = json.loads((finished / "summary.json").read_text())
    assert summary["completed"]
    assert (summary["seeds"], summary["failed_seeds"]) == ([0, 1], [])
    assert summary["final"]["expert_trajectories"]["mean"] == 50
    metrics = RunFolder.open(finished).metrics()
    assert metrics["iteration"].to_list() == [*range(11)] * 2


def test_whoever_watches_a_run_is_told_its_metrics_chunk_by_chunk(finished):
    metrics = RunFolder.open(finished).metrics()
    assert len(TOLD) == len(list((finished / "metrics").iterdir())) > 1
    told = polars.concat([polars.DataFrame(dict(rows)) for rows in TOLD], how="diagonal").sort("seed", "iteration")
    assert_frame_equal(told, metrics, check_dtypes=False, check_column_order=False, check_exact=True)


@pytest.mark.slow
def test_the_same_run_again_gives_identical_bytes_and_leaves_jaxs_switches_as_they_were(finished, tmp_path):
    with jax.enable_x64(False):
        runner.run(tiny_config(**LEARNERS["simple"]), tmp_path / "again")
        assert not jax.config.jax_enable_x64  # pyright: ignore[reportAttributeAccessIssue]
    assert bytes_of(tmp_path / "again") == bytes_of(finished)


def test_what_stands_after_the_first_checkpoint_resumes_to_identical_bytes(finished, tmp_path):
    halfway = shutil.copytree(finished.parent / "halfway", tmp_path / "halfway")
    assert RunFolder.open(halfway).metrics()["iteration"].max() == 4
    runner.resume(halfway)
    assert bytes_of(halfway) == bytes_of(finished)


@pytest.mark.slow
@pytest.mark.parametrize("learner", ["simple", "default"])
def test_an_interrupted_run_resumes_to_identical_bytes(learner, finished, tmp_path, monkeypatch):
    config = tiny_config(**LEARNERS[learner])
    whole = finished
    if learner != "simple":
        whole = tmp_path / "whole"
        runner.run(config, whole)
    save = RunFolder.save_checkpoint

    def save_and_stop(*arguments: object) -> None:
        save(*arguments)  # pyright: ignore[reportArgumentType]
        raise KeyboardInterrupt

    monkeypatch.setattr(RunFolder, "save_checkpoint", save_and_stop)
    with pytest.raises(KeyboardInterrupt):
        runner.run(config, tmp_path / "cut")
    monkeypatch.undo()
    assert not (tmp_path / "cut" / "summary.json").exists()
    runner.resume(tmp_path / "cut")
    assert bytes_of(tmp_path / "cut") == bytes_of(whole)


@pytest.mark.slow
def test_a_run_interrupted_before_its_first_checkpoint_starts_over(finished, tmp_path, monkeypatch):
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(RunFolder, "save_checkpoint", stop)
    with pytest.raises(KeyboardInterrupt):
        runner.run(tiny_config(**LEARNERS["simple"]), tmp_path / "cut")
    monkeypatch.undo()
    runner.resume(tmp_path / "cut")
    assert bytes_of(tmp_path / "cut") == bytes_of(finished)


@pytest.mark.parametrize("number", [1, 3, 4])
@pytest.mark.parametrize("together", [None, 2])
def test_every_seed_is_computed_with_its_own_state_in_the_order_of_seeds(number, together):
    seeds, states = jnp.arange(5, 5 + number), jnp.arange(2.0 * number).reshape(number, 2)

    def function(seed, state):
        return {"seed": seed, "sum": seed + jnp.sum(state)}

    after = runner.over_seeds(together, function, seeds, states)
    np.testing.assert_array_equal(after["seed"], seeds)
    np.testing.assert_array_equal(after["sum"], [5 + n + 2 * n + (2 * n + 1) for n in range(number)])


def test_resuming_a_finished_run_changes_nothing(finished):
    before = {path: path.read_bytes() for path in finished.rglob("*") if path.is_file()}
    runner.resume(finished)
    assert {path: path.read_bytes() for path in finished.rglob("*") if path.is_file()} == before


@pytest.mark.slow
@pytest.mark.parametrize("algorithm", ["ma-irl", "marl"])
def test_baselines_run(algorithm, tmp_path):
    runner.run(tiny_config(algorithm=algorithm, iterations=2), tmp_path / "run")
    summary = RunFolder.open(tmp_path / "run").summary()
    assert summary is not None
    assert summary.completed
    assert summary.failed_seeds == []
    assert ("expert_reward_pearson" in summary.final) == (algorithm == "ma-irl")


@pytest.mark.slow
def test_a_users_network_runs_and_resumes_after_its_file_is_gone(tmp_path, monkeypatch):
    graph = tmp_path / "office.json"
    graph.write_text((Path(__file__).parents[2] / "examples" / "office.json").read_text())

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    config = tiny_config(algorithm="marl", graph=str(graph), seeds=1)
    monkeypatch.setattr(RunFolder, "append_metrics", stop)
    with pytest.raises(KeyboardInterrupt):
        runner.run(config, tmp_path / "run")
    monkeypatch.undo()
    graph.unlink()
    runner.resume(tmp_path / "run")
    summary = RunFolder.open(tmp_path / "run").summary()
    assert summary is not None
    assert summary.completed


FLAGS = "--nodes 4 --edges 5 --horizon 3 --seeds 2 --iterations 10 --trajectories 5 --inner-steps 2 --remembered 3"


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "gsiirl", *arguments]


@pytest.mark.slow
def test_a_killed_run_resumes_to_identical_bytes(tmp_path):
    begin = command("run", "security", *FLAGS.split(), "--out")
    started = time.monotonic()
    subprocess.run([*begin, str(tmp_path / "whole")], check=True, capture_output=True)
    took = time.monotonic() - started
    for part in (0.5, 0.8):
        out = tmp_path / f"killed at {part}"
        process = subprocess.Popen([*begin, str(out)], stdout=subprocess.DEVNULL)
        time.sleep(part * took)
        process.send_signal(signal.SIGKILL)
        process.wait()
        # Killed before it was begun, it is begun; else it is gone on with.
        again = command("resume", str(out)) if (out / "config.json").exists() else [*begin, str(out)]
        subprocess.run(again, check=True, capture_output=True)
        assert bytes_of(out) == bytes_of(tmp_path / "whole")
