import csv
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gsiirl.cli import main
from gsiirl.runs import RunFolder, summarise
from gsiirl.runs.learned import Interval


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run of two seeds and two iterations, with one reward that has intervals and one that has none."""
    folder = RunFolder.create(tmp_path / "run", {"experiment": "security", "algorithm": "gsiirl"}, {"name": "g"})
    folder.append_metrics(
        0,
        {
            "seed": np.array([0, 1, 0, 1]),
            "iteration": np.array([0, 0, 1, 1]),
            "deployed_return_learner": np.array([-3.0, -2.0, -1.5, -1.25]),
            "late": np.array([np.nan, np.nan, 7.0, 8.0]),
        },
    )
    interval = Interval(0.9, [0.5], [1.5], [True])
    folder.save_learned(
        {"dependent_reward": np.array([[0.5, 0.25], [0.5, 0.125]]), "expert_reward": np.array([[0.1], [0.2]])},
        {"dependent_reward": 2.0, "expert_reward": 10.0},
        {"dependent_reward": ["a", "b, c"], "expert_reward": ["d"]},
        [0, 1],
        {"expert_reward": [interval, None]},
    )
    folder.write_summary(summarise(folder.config, folder.metrics(), completed=True))
    return folder.path


def test_csv_files_hold_metrics_and_weights_in_reward_units(run: Path, tmp_path: Path, capsys):
    assert main(["export", str(run), "--to", "csv", "--out", str(tmp_path / "csv")]) == 0
    named = [Path(line).name for line in capsys.readouterr().out.splitlines()]
    assert named == ["metrics.csv", "learned.csv"]
    with (tmp_path / "csv" / "metrics.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["seed"], row["iteration"], float(row["deployed_return_learner"])) for row in rows] == [
        ("0", "0", -3.0),
        ("0", "1", -1.5),
        ("1", "0", -2.0),
        ("1", "1", -1.25),
    ]
    with (tmp_path / "csv" / "learned.csv").open() as file:
        learned = list(csv.DictReader(file))
    weights = {(row["seed"], row["weight_of"]): float(row["weight"]) for row in learned}
    assert weights == pytest.approx(
        {("0", "a"): 1.0, ("0", "b, c"): 0.5, ("1", "a"): 1.0, ("1", "b, c"): 0.25, ("0", "d"): 1.0, ("1", "d"): 2.0}
    )
    assert [(row["low"], row["high"], row["determined"]) for row in learned if row["weight_of"] == "d"] == [
        ("0.5", "1.5", "true"),
        ("", "", ""),
    ]


def events(folder: Path) -> list[tuple[str, int, float]]:
    """Scalars of an event file: records of TensorFlow's form, each of length, its checksum, content, its checksum."""
    from tensorboardX.proto import event_pb2

    # Its classes are made when it is imported, which a type checker does not see.
    kind: Any = vars(event_pb2)["Event"]

    (file,) = folder.iterdir()
    content, place, found = file.read_bytes(), 0, list[tuple[str, int, float]]()
    while place < len(content):
        (length,) = struct.unpack_from("<Q", content, place)
        event = kind.FromString(content[place + 12 : place + 12 + length])
        found += [(value.tag, event.step, value.simple_value) for value in event.summary.value]
        place += length + 16
    return found


def test_tensorboard_gets_a_curve_for_each_metric_of_each_seed(run: Path, tmp_path: Path):
    assert main(["export", str(run), "--to", "tensorboard", "--out", str(tmp_path / "events")]) == 0
    assert {each.name for each in (tmp_path / "events").iterdir()} == {"seed-0", "seed-1"}
    assert events(tmp_path / "events" / "seed-1") == [
        ("deployed_return_learner", 0, -2.0),
        ("deployed_return_learner", 1, -1.25),
        ("late", 1, 8.0),
    ]


def test_without_tensorboardx_the_mend_is_to_install_it(run: Path, tmp_path: Path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "tensorboardX", None)
    assert main(["export", str(run), "--to", "tensorboard", "--out", str(tmp_path / "events")]) == 2
    assert "--to: tensorboard needs tensorboardX, which is not installed; install it with" in capsys.readouterr().err


def test_files_of_the_users_are_left_alone(run: Path, tmp_path: Path, capsys):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "metrics.csv").write_text("mine")
    assert main(["export", str(run), "--to", "csv", "--out", str(tmp_path / "mine")]) == 2
    assert "is not empty; use a new or empty folder" in capsys.readouterr().err
    assert (tmp_path / "mine" / "metrics.csv").read_text() == "mine"
