"""`gsiirl evaluate` plays the pair it is asked for, of every seed that did not fail, and refuses other runs."""

import itertools
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import polars
import pytest
from resealing import rewrite

from gsiirl.adapters import mpe2
from gsiirl.adapters.numpy_policy import NumpyPolicy
from gsiirl.cli import main
from gsiirl.experiments.config import ExperimentConfig, config_to_dict
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.program.command import installing
from gsiirl.runs import RunFolder, summarise

HORIZON, EPISODES, HIDDEN = 4, 3, 5
NETWORKS = {"learner": (20, 4), "expert": (8, 2), "response": (8, 2)}


def weights_of(names: list[str], seeds: int) -> dict[str, np.ndarray]:
    random, weights = np.random.default_rng(0), {}
    for name in names:
        observation, actions = NETWORKS[name]
        sizes = (observation + 1, HIDDEN, HIDDEN, actions)
        for layer, (inputs, outputs) in enumerate(itertools.pairwise(sizes)):
            weights[f"{name}.layers.{layer}.weight"] = random.normal(size=(seeds, outputs, inputs)).astype(np.float32)
            weights[f"{name}.layers.{layer}.bias"] = random.normal(size=(seeds, outputs)).astype(np.float32)
    return weights


def finished_run(path: Path, config: ExperimentConfig | None = None, failed: int | None = None) -> RunFolder:
    """A run of seeds 3, 4, 5 that ended; of returns measured in our port that tell the pairs, sides and seeds apart."""
    config = config or DeceptionConfig(seeds=3, first_seed=3, horizon=HORIZON)
    folder = RunFolder.create(path, config_to_dict(config.resolved()), {"kind": "deception"})
    columns: dict[str, Any] = {"seed": [3, 4, 5], "iteration": [0, 0, 0]}
    for pair, of_pair in (("deployed", 100.0), ("model", 200.0)):
        for side, of_side in (("learner", 10.0), ("expert", 20.0)):
            columns[f"{pair}_return_{side}"] = [
                np.nan if seed == failed else of_pair + of_side + seed for seed in columns["seed"]
            ]
    folder.save_policies(weights_of(list(NETWORKS), 3))
    folder.write_summary(summarise(folder.config, polars.DataFrame(columns), completed=True))
    return folder


def evaluate(run: RunFolder, *flags: str) -> dict[str, Any]:
    assert main(["evaluate", str(run.path), "--in", "mpe2", "--episodes", str(EPISODES), *flags]) == 0
    return json.loads((run.path / "evaluation-mpe2.json").read_text())


def played(run: RunFolder, learner: str, expert: str, place: int) -> list[float]:
    """Mean returns of a pair of the run's networks."""
    weights = run.load_policies()
    assert weights is not None
    environment = mpe2.simple_adversary(HORIZON)
    pair = NumpyPolicy.of(weights, learner, place), NumpyPolicy.of(weights, expert, place)
    return np.mean([mpe2.play(environment, HORIZON, *pair, seed) for seed in range(EPISODES)], axis=0).tolist()


@pytest.mark.parametrize(
    ("algorithm", "pair", "expert"),
    [
        ("gsiirl", "deployed", "response"),
        ("gsiirl", "model", "expert"),
        ("marl", "deployed", "response"),
        ("marl", "model", "expert"),
    ],
)
def test_the_pair_asked_for_is_played(algorithm: Any, pair: str, expert: str, tmp_path: Path):
    config = DeceptionConfig(algorithm=algorithm, seeds=3, first_seed=3, horizon=HORIZON)
    run = finished_run(tmp_path / "run", config)
    found = evaluate(run, "--pair", pair)
    assert (found["pair"], found["networks"]) == (pair, {"learner": "learner", "expert": expert})
    assert (found["format_version"], found["episodes"], found["seeds"]) == (1, EPISODES, [3, 4, 5])
    for place in range(3):
        here = [found["in_mpe2"][side]["per_seed"][place] for side in ("learner", "expert")]
        assert here == pytest.approx(played(run, "learner", expert, place), abs=1e-9)
        assert found["in_mpe2"]["sum"]["per_seed"][place] == pytest.approx(sum(here))
    base = {"deployed": 100.0, "model": 200.0}[pair]
    assert found["in_port"]["learner"]["per_seed"] == [base + 13.0, base + 14.0, base + 15.0]
    assert found["in_port"]["expert"] == {
        "mean": base + 24.0,
        "std": 1.0,
        "per_seed": [base + 23, base + 24, base + 25],
    }


def test_a_failed_seed_is_named_and_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    run = finished_run(tmp_path / "run", failed=4)
    found = evaluate(run)
    assert (found["seeds"], found["failed_seeds"]) == ([3, 5], [4])
    assert found["in_port"]["learner"]["per_seed"] == [113.0, 115.0]
    assert found["in_mpe2"]["learner"]["per_seed"][1] == pytest.approx(played(run, "learner", "response", 2)[0])
    assert capsys.readouterr().err == f"gsiirl: {run.path}: left out failed seeds 4\n"


def test_the_table_has_a_row_a_seed(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    evaluate(finished_run(tmp_path / "run"))
    shown = capsys.readouterr().out
    rows = [line.replace("│", " ").split() for line in shown.splitlines() if line.startswith("│")]
    assert [row[0] for row in rows] == ["3", "4", "5", "mean", "±"]
    assert [row[2::2] for row in rows[:4]] == [
        ["113.00", "123.00", "236.00"],
        ["114.00", "124.00", "238.00"],
        ["115.00", "125.00", "240.00"],
        ["114.00", "124.00", "238.00"],
    ]
    assert str(tmp_path / "run" / "evaluation-mpe2.json") in shown.replace("\n", "")


@pytest.mark.parametrize(
    ("config", "problem"),
    [
        (CrossingConfig(seeds=3), "is a run of crossing, which mpe2 does not have; give the folder of a finished"),
        (
            DeceptionConfig(seeds=3, variant="separate_target"),
            "is of variant separate_target, but in mpe2 both sides share a target; give one of mpe",
        ),
    ],
)
def test_a_run_of_another_game_is_refused(config: ExperimentConfig, problem: str, tmp_path: Path, refused):
    run = finished_run(tmp_path / "run", config)
    assert f"{run.path}: {problem}" in refused(run.path)


def test_a_run_that_is_not_finished_is_refused(tmp_path: Path, refused):
    run = finished_run(tmp_path / "run")
    summary = run.path / "summary.json"
    rewrite(summary, '"completed": true', '"completed": false')
    expected = f"{run.path}: holds a run that is not finished; run gsiirl resume {run.path}"
    assert refused(run.path) == expected
    summary.unlink()
    assert refused(run.path) == expected


def test_a_folder_without_a_run_is_refused(tmp_path: Path, refused):
    assert refused(tmp_path).startswith(f"{tmp_path}: is no run folder")
    assert refused(tmp_path / "missing").startswith(f"{tmp_path / 'missing'}: is no folder")


def test_a_run_without_policies_is_refused(tmp_path: Path, refused):
    run = finished_run(tmp_path / "run")
    path = run.path / "policies.safetensors"
    path.unlink()
    assert refused(run.path) == f"{path}: is missing; start the run again in another folder"
    # One of an earlier version names no files.
    rewrite(run.path / "summary.json", '"policies.safetensors"', "")
    assert "keeps no policies" in refused(run.path)


def test_damaged_policies_are_refused(tmp_path: Path, refused):
    run = finished_run(tmp_path / "run")
    weights, path = run.load_policies(), run.path / "policies.safetensors"
    assert weights is not None
    run.save_policies({name: array for name, array in weights.items() if not name.startswith("response")})
    assert refused(run.path).startswith(f"{path}: is damaged: it holds no response of physical deception")
    run.save_policies(weights | {"learner.layers.2.bias": weights["expert.layers.2.bias"]})
    assert refused(run.path).startswith(f"{path}: is damaged: it holds no learner of physical deception")
    run.save_policies({name: array[:2] for name, array in weights.items()})
    assert refused(run.path).startswith(f"{path}: is damaged: it is not of all seeds")
    path.write_bytes(b"nothing")
    assert refused(run.path).startswith(f"{path}: is damaged")


def test_mpe2_is_asked_for_where_it_is_missing(tmp_path: Path, refused, monkeypatch: pytest.MonkeyPatch):
    run = finished_run(tmp_path / "run")
    monkeypatch.setitem(sys.modules, "mpe2", None)
    assert refused(run.path) == f"--in: mpe2 is not installed; run {installing('mpe2>=1.1.1')}"


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]):
    """The one line with which a run is refused, with nothing written."""

    def message(path: Path) -> str:
        assert main(["evaluate", str(path), "--in", "mpe2"]) == 2
        captured = capsys.readouterr()
        assert captured.out == ""
        [line] = captured.err.splitlines()
        assert not (path / "evaluation-mpe2.json").exists()
        return line.removeprefix("gsiirl: ")

    return message


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('"seeds"', '"sorts"', "summary.json: is damaged: seeds: Field required"),
        (
            '"failed_seeds": []',
            '"failed_seeds": 0',
            "summary.json: is damaged: failed_seeds: Input should be a valid array",
        ),
        (
            '"completed": true',
            '"completed": "no"',
            "summary.json: is damaged: completed: Input should be a valid boolean",
        ),
        ('"final"', '"last"', "summary.json: is damaged: final: Field required"),
        ('"deployed_return_expert"', '"return"', "summary.json: is damaged: final holds no deployed_return_expert"),
    ],
)
def test_a_damaged_summary_is_refused(old: str, new: str, problem: str, tmp_path: Path, refused):
    run = finished_run(tmp_path / "run")
    rewrite(run.path / "summary.json", old, new)
    assert problem in refused(run.path)


@pytest.mark.parametrize("change", [lambda each: each * np.nan, lambda each: each[:, 0], lambda each: each[0, 0, 0]])
def test_weights_that_cannot_be_are_refused(change: Any, tmp_path: Path, refused):
    run = finished_run(tmp_path / "run")
    weights = run.load_policies()
    assert weights is not None
    name = "response.layers.1.weight"
    run.save_policies(weights | {name: np.asarray(change(weights[name]))})
    assert refused(run.path).startswith(f"{run.path / 'policies.safetensors'}: is damaged")
