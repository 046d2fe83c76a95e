"""An environment takes an experiment's settings, and says in one line what it cannot take."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from pettingzoo_runs import security_run

from gsiirl.errors import InputError
from gsiirl.pettingzoo import parallel_env, run_env
from gsiirl.program.command import installing

OFFICE = Path(__file__).parents[2] / "examples" / "office.json"


@pytest.mark.parametrize(
    ("experiment", "settings", "told"),
    [
        ("chess", {}, "experiment: cannot be 'chess'; choose security or crossing or deception"),
        ("game", {}, "experiment: cannot be 'game'"),
        ("security", {"grph": "tiny"}, "grph: is no field of the security experiment; did you mean graph?"),
        ("crossing", {"horizon": 0}, "horizon: cannot be 0; give a whole number of at least 1"),
        ("security", {"graph": "no-such-network"}, "no-such-network"),
    ],
)
def test_what_it_cannot_be_is_told_in_one_line(experiment: str, settings: dict[str, Any], told: str):
    with pytest.raises(InputError) as caught:
        parallel_env(experiment, **settings)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_without_pettingzoo_the_command_that_installs_it_is_told():
    code = (
        "import sys; sys.modules |= dict.fromkeys(['pettingzoo', 'gymnasium'])\n"
        "from gsiirl.pettingzoo import parallel_env\n"
        "parallel_env('crossing')"
    )
    finished = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    told = f"gsiirl.pettingzoo: pettingzoo is not installed; run {installing('pettingzoo>=1.24')}"
    assert finished.stderr.splitlines()[-1] == f"gsiirl.errors.InputError: {told}"


def test_settings_make_the_game():
    env = parallel_env("security", graph=str(OFFICE), expert_no_op=True, horizon=3)
    assert (env.action_space("defender").n, env.action_space("attacker").n) == (6, 7)  # pyright: ignore[reportAttributeAccessIssue]
    assert env.observation_space("attacker").shape == (4 + 1,)


def test_the_environment_of_a_run_needs_no_more_the_file_that_its_network_came_from(tmp_path: Path):
    own = tmp_path / "own.json"
    own.write_text(OFFICE.read_text())
    security_run(tmp_path / "run", graph=str(own), horizon=2)
    own.unlink()
    env = run_env(tmp_path / "run")
    assert env.observation_space("attacker").shape == (4 + 1,)
    env.reset(seed=0)
    env.step({"defender": 0, "attacker": 0})
    assert env.agents == ["defender", "attacker"]
    env.step({"defender": 0, "attacker": 0})
    assert env.agents == []
