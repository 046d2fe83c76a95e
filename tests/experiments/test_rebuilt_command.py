"""The command that a report tells makes the run again."""

import shlex
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import gsiirl.experiments
from gsiirl.cli import main
from gsiirl.experiments.config import EXPERIMENTS, config_to_dict, load_config
from gsiirl.report.read.made import Made
from gsiirl.runs import RunFolder


@pytest.mark.parametrize(
    ("experiment", "given"),
    [
        ("security", {}),
        ("security", {"algorithm": "paper", "graph_seed": 3, "expert_no_op": True, "seeds": 2}),
        ("security", {"algorithm": "gsiirl", "commitment": "reward", "honest_start": False}),
        ("security", {"temperature": "unknown", "first_seed": 7}),
        ("crossing", {"reward": "network"}),
        ("deception", {"algorithm": "marl", "solver": "maddpg"}),
        ("game", {"file": "mine.py:game"}),
    ],
)
def test_every_setting_is_in_the_command(
    experiment: str, given: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    runner = ModuleType("gsiirl.experiments.runner")
    runner.__dict__.update(run=lambda config, out, told=None, rows_to=None: asked.append(config.resolved()))
    monkeypatch.setitem(sys.modules, runner.__name__, runner)
    monkeypatch.setattr(gsiirl.experiments, "runner", runner, raising=False)
    config = load_config(EXPERIMENTS[experiment], given).resolved()
    folder = RunFolder.create(tmp_path / "run", config_to_dict(config), {})
    assert main(shlex.split(Made.of(folder, None, [0]).command)[1:]) == 0
    assert asked == [config]
