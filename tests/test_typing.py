"""A type checker sees the library's classes as what they are."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"
SHOWN = """
reveal_type(gsiirl.GSIIRL)
reveal_type(gsiirl.RewardGSIIRL)
reveal_type(gsiirl.SimulatedExpert)
reveal_type(gsiirl.Bilevel)
reveal_type(gsiirl.load)
reveal_type(problem)
reveal_type(expert)
reveal_type(result)
reveal_type(result.policy)
reveal_type(told)
"""
CONTINUOUS = """
import jax

import gsiirl
from gsiirl.games import Crossing
from gsiirl.rewards import crossing as rewards

game, features, own_features = Crossing(horizon=4), rewards.HumanFeatures(), rewards.RobotFeatures()
problem = gsiirl.Problem(
    game, rewards.own_reward, rewards.dependent_reward, expert_features=features, dependent_features=own_features
)
expert = gsiirl.ContinuousRespondingExpert(game, rewards.human_reward, 0.95, steps=3, first_steps=3, hidden=4)
result = gsiirl.GSIIRL(problem, hidden=4, solver_steps=3).fit(expert, iterations=2, trajectories=4, seed=0)
action = result.act(game.reset(jax.random.key(0)), 0)
told = result.evaluate(rewards.human_reward, training_steps=3)
"""
CLASSES = {
    "gsiirl.GSIIRL(problem)": "ContinuousGSIIRL",
    "gsiirl.GSIIRL(problem).fit(expert, seeds=2)": "ContinuousResults",
    "problem": "ContinuousProblem",
    "expert": "ContinuousRespondingExpert",
    "result": "ContinuousResult",
    "result.policy": "PolicyNetwork",
    "result.expert_reward": "LearnedTransitionReward",
    "result.history": "DataFrame",
    "action": "ndarray[tuple[Any, ...], dtype[Any]]",
    "told": "ContinuousEvaluation",
}


@pytest.fixture(scope="module")
def revealed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """What a type checker reveals of the two programs, in which it finds no error."""
    folder = tmp_path_factory.mktemp("programs")
    [program] = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    shown = "".join(f"reveal_type({expression})\n" for expression in CLASSES)
    (folder / "finite.py").write_text(program + SHOWN)
    (folder / "continuous.py").write_text(CONTINUOUS + shown)
    command = [sys.executable, "-m", "basedpyright", "--outputjson", "--pythonpath", sys.executable, "."]
    ended = subprocess.run(command, capture_output=True, text=True, cwd=folder, check=False)
    said = json.loads(ended.stdout)["generalDiagnostics"]
    assert [each["message"] for each in said if each["severity"] == "error"] == []
    told: dict[str, list[str]] = {"finite": [], "continuous": []}
    for each in said:
        if each["severity"] == "information":
            told[Path(each["file"]).stem].append(each["message"])
    return told


def test_a_users_program_is_fully_typed(revealed: dict[str, list[str]]) -> None:
    types = revealed["finite"]
    assert len(types) == len(SHOWN.split())
    assert [each for each in types if re.search(r'is "(type\[)?(Any|Unknown)\b', each)] == []


def test_a_users_program_of_a_continuous_game_is_fully_typed(revealed: dict[str, list[str]]) -> None:
    assert revealed["continuous"] == [f'Type of "{expression}" is "{name}"' for expression, name in CLASSES.items()]
    assert len(CONTINUOUS.strip().splitlines()) <= 15


@pytest.mark.slow
def test_a_users_program_of_a_continuous_game_runs(tmp_path: Path) -> None:
    program = CONTINUOUS + "print(result, action.shape, *told)\n"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path, check=False)
    expected = "ContinuousResult(ContinuousProblem(Crossing, 2 and 2 actions, 4 steps, "
    assert ended.stdout.startswith(expected), ended.stderr
    assert "(2,) deployed marl random" in ended.stdout
