"""A run on one's own game, from a file to a loaded result."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gsiirl
from gsiirl.cli import main
from gsiirl.errors import InputError
from gsiirl.experiments.game.config import GameConfig
from gsiirl.experiments.game.file import read_game
from gsiirl.report import build_report

RANDOM = np.random.default_rng(0)
ARRAYS: dict[str, Any] = {
    "transitions": RANDOM.dirichlet(np.ones(2), (2, 2, 2)),
    "initial": np.array([0.5, 0.5]),
    "horizon": 2,
    "own_reward": RANDOM.uniform(-0.3, 0.3, (2, 2)),
    "dependent_value": RANDOM.uniform(-1, 1, (2, 2, 2)),
    "expert_reward": RANDOM.uniform(-1, 1, (2, 2, 2)),
    "temperature": 0.4,
    "discount": 0.9,
}

FUNCTION = """
import numpy as np, gsiirl
def duel():
    game = gsiirl.games.TabularGame.from_arrays(np.ones((1, 2, 2, 1)), initial=[1.0], horizon=1)
    problem = gsiirl.Problem(game, dependent_value=[[[2, 4], [1, 3]]], discount=1.0, temperature=0.3)
    return problem, np.array([[[1.0, 0.0], [0.0, 1.0]]])
def nothing():
    return 3
"""


def written(folder: Path, **changes: Any) -> str:
    """An .npz of the game with some arrays changed, or left out where they are None."""
    path = folder / "mine.npz"
    np.savez(path, **{name: each for name, each in (ARRAYS | changes).items() if each is not None})
    return str(path)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("game")
    file = written(folder)
    run = str(folder / "run")
    flags = ["--seeds", "2", "--iterations", "5", "--trajectories", "20"]
    assert main(["run", "game", file, "--out", run, *flags]) == 0
    return folder / "run"


@pytest.mark.slow
def test_a_run_of_ones_own_game_has_its_yardsticks(finished: Path):
    summary = json.loads((finished / "summary.json").read_text())
    final = {name: each["mean"] for name, each in summary["final"].items()}
    assert summary["failed_seeds"] == []
    assert final["ceiling_return_learner"] >= final["random_return_learner"]
    assert -1e-6 <= final["regret"] <= 0.2
    assert final["expert_trajectories"] == 100


@pytest.mark.slow
def test_a_run_is_loaded_seed_by_seed_and_evaluated(finished: Path):
    for seed in (0, 1):
        result = gsiirl.load(finished, seed=seed)
        assert result.policy.shape == (2, 2, 2)
        low, high = result.expert_reward.interval(0.98)
        assert ((low <= result.expert_reward.table) & (result.expert_reward.table <= high)).all()
        earns = result.return_interval(0.98)
        assert earns[0] - 1e-9 <= result.evaluate(ARRAYS["expert_reward"])["deployed"] <= earns[1] + 1e-9
        np.testing.assert_allclose(result.policy.sum(-1), 1.0, atol=1e-12)
        recorded = json.loads((finished / "summary.json").read_text())["final"]["deployed_return_learner"]["per_seed"]
        np.testing.assert_allclose(
            result.evaluate(ARRAYS["expert_reward"]).undiscounted["deployed"], recorded[seed], atol=1e-9
        )
    with pytest.raises(InputError, match="seed: 7 is not in"):
        gsiirl.load(finished, seed=7)


@pytest.mark.slow
def test_a_run_goes_on_without_the_file_it_came_from_and_is_reported(finished: Path, tmp_path: Path):
    assert main(["resume", str(finished)]) == 0
    page = build_report([finished], tmp_path / "report").page.read_text()
    assert "mine" in page
    assert "regret" in page


def test_a_function_of_a_python_file_gives_problem_and_truth(tmp_path: Path):
    path = tmp_path / "mine.py"
    path.write_text(FUNCTION)
    own = read_game(f"{path}:duel", told_temperature=True)
    assert (own.problem.game.horizon, own.temperature, own.problem.temperature) == (1, 0.3, 0.3)
    assert read_game(f"{path}:duel", told_temperature=False).problem.temperature is None
    for name, message in (("nothing", "returned int"), ("absent", "has no function absent")):
        with pytest.raises(InputError, match=message):
            read_game(f"{path}:{name}", told_temperature=True)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"initial": None}, "initial in .*mine.npz: is missing"),
        ({"transitions": None}, "transitions in .*mine.npz: is missing"),
        ({"reward": 1.0}, "reward in .*mine.npz: is no array of a game"),
        ({"horizon": 1.5}, "horizon in .*mine.npz: cannot be 1.5"),
        ({"horizon": np.ones(2)}, "horizon in .*mine.npz: is float64 of shape"),
        ({"temperature": -1.0}, "temperature in .*mine.npz: cannot be -1.0"),
        ({"own_reward": np.ones(3)}, "own_reward: has shape"),
        ({"expert_reward": np.ones((2, 2))}, "expert_reward: has shape"),
        ({"initial": np.array([0.5, np.nan])}, "initial: is nan"),
        ({"initial": np.array([None, 1])}, "FILE: .* is no .npz of plain arrays"),
    ],
)
def test_a_file_that_holds_no_game_is_told_in_one_line(tmp_path: Path, changes: dict[str, Any], message: str):
    with pytest.raises(InputError, match=message) as raised:
        read_game(written(tmp_path, **changes), told_temperature=True)
    assert "\n" not in str(raised.value)


def test_a_run_without_a_file_is_told():
    with pytest.raises(InputError, match=r"FILE: is missing; give FILE\.npz"):
        GameConfig().resolved()
    with pytest.raises(InputError, match=r"FILE: absent\.npz is no file"):
        read_game("absent.npz", told_temperature=True)
