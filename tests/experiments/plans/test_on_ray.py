import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from gsiirl.cli import main

SWEEP = """
experiment = "security"
nodes = 4
edges = 5
horizon = 3
algorithm = ["ma-irl", "marl"]
first_seed = [0, 2, 4]
seeds = 2
iterations = 7
trajectories = 5
"""


def outcome(folder: Path) -> dict[str, bytes]:
    """Every file of every run but those that say when and how long, and what a killed process left aside."""
    files = [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".aside"]
    kept = [path for path in files if path.name not in ("environment.json", ".lock")]
    return {str(path.relative_to(folder)): path.read_bytes() for path in kept}


def workers() -> list[int]:
    """Processes of Ray that do a run."""
    named = subprocess.run(["pgrep", "-f", "^ray::in_worker"], capture_output=True, text=True).stdout
    return [int(each) for each in named.split()]


@pytest.mark.slow
def test_a_sweep_on_ray_ends_as_one_on_this_machine_though_its_workers_are_killed(tmp_path: Path):
    pytest.importorskip("ray")
    (tmp_path / "sweep.toml").write_text(SWEEP)
    command = [sys.executable, "-m", "gsiirl", "sweep", str(tmp_path / "sweep.toml"), "--quiet"]
    subprocess.run([*command, "--jobs", "2", "--out", str(tmp_path / "local")], check=True, capture_output=True)
    process = subprocess.Popen([*command, "--engine", "ray", "--jobs", "2", "--out", str(tmp_path / "ray")])
    killed = 0
    while process.poll() is None and killed < 2:
        time.sleep(1.0)
        for each in workers()[:1]:
            os.kill(each, signal.SIGKILL)
            killed += 1
    assert process.wait() == 0
    assert killed == 2
    assert outcome(tmp_path / "ray") == outcome(tmp_path / "local")


def test_an_address_without_a_cluster_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "sweep.toml").write_text(SWEEP)
    command = ["sweep", str(tmp_path / "sweep.toml"), "--out", str(tmp_path / "out")]
    assert main([*command, "--address", "127.0.0.1:1"]) == 2
    assert "--address: is of a Ray cluster; add --engine ray" in capsys.readouterr().err


def test_without_ray_the_mend_is_to_install_it(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    (tmp_path / "sweep.toml").write_text(SWEEP)
    command = ["sweep", str(tmp_path / "sweep.toml"), "--out", str(tmp_path / "out"), "--engine", "ray"]
    assert main(command) == 2
    assert "--engine: ray is not installed; install it with" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
