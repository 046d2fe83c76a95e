"""A recorded trajectory is told step by step."""

from pathlib import Path

import numpy as np
import pytest
from report.synthetic import SyntheticGame

from gsiirl.errors import InputError
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.security.recorded_graph import RecordedGraph
from gsiirl.report.security.sample_path import SamplePath, pick_sample_path
from gsiirl.runs import RunFolder

GRAPH = {"nodes": ["a", "b", "c"], "footholds": ["a"], "edges": [("a", "b", 0.5), ("b", "c", 0.5)]}
NO_OP = 2


def path_of(folder: Path, steps: list[tuple[int, int, int]], seed: int = 0) -> SamplePath:
    """Of one trajectory given as (state, attacked edge, blocked edge), beside a duller one."""
    game = SyntheticGame(GRAPH).content()
    run = RunFolder.create(folder / "run", {"experiment": "security", "algorithm": "gsiirl"}, game)
    run.append_metrics(0, {"seed": np.array([seed]), "iteration": np.array([0])})
    dull = [(seed, 0, step, 0b001, NO_OP, NO_OP) for step in range(len(steps))]
    told = [(seed, 1, step, state, block, attack) for step, (state, attack, block) in enumerate(steps)]
    names = ("seed", "trajectory", "step", "state", "learner_action", "expert_action")
    run.save_paths(dict(zip(names, np.array(dull + told).T, strict=True)))
    graph = RecordedGraph.read(game, run.path)
    path = pick_sample_path(graph, ReportedRun.read(run.path))
    assert path is not None
    return path


def test_outcomes_follow_from_states_and_actions(tmp_path: Path) -> None:
    path = path_of(
        tmp_path,
        [
            (0b001, 1, 0),  # b is not held: nothing can come of attacking c from it
            (0b001, 0, 0),  # blocked
            (0b001, 0, 1),  # fails
            (0b001, 0, NO_OP),  # succeeds
            (0b011, 0, 1),  # b is held already
            (0b011, NO_OP, 1),
            (0b011, 1, 0),  # the last: what came of it is not recorded
        ],
    )
    assert [step.outcome for step in path.steps] == [
        "wasted",
        "blocked",
        "failed",
        "taken",
        "wasted",
        "idle",
        "unknown",
    ]
    assert [set(step.fallen) for step in path.steps] == [set(), set(), set(), {1}, set(), set(), set()]
    assert [len(step.compromised) for step in path.steps] == [1, 1, 1, 2, 2, 2, 2]
    assert path.steps[3].attack == "a → b"
    assert path.steps[3].block == "nothing"


def test_the_trajectory_in_which_most_falls_is_told(tmp_path: Path) -> None:
    path = path_of(tmp_path, [(0b001, 0, 1), (0b011, 1, 0), (0b111, NO_OP, NO_OP)], seed=4)
    assert (path.seed, path.trajectory, path.recorded) == (4, 1, 2)


def test_a_missing_column_is_named(tmp_path: Path) -> None:
    game = SyntheticGame(GRAPH).content()
    run = RunFolder.create(tmp_path / "run", {"experiment": "security", "algorithm": "gsiirl"}, game)
    run.append_metrics(0, {"seed": np.array([0]), "iteration": np.array([0])})
    run.save_paths({name: np.array([0]) for name in ("seed", "trajectory", "step", "state", "learner_action")})
    with pytest.raises(InputError, match=r"paths.parquet: is damaged: it has no column expert_action"):
        pick_sample_path(RecordedGraph.read(game, run.path), ReportedRun.read(run.path))


def test_the_states_of_a_large_network_are_in_several_columns(tmp_path: Path) -> None:
    names = [f"h{number}" for number in range(70)]
    edges = [(names[place], names[place + 1], 0.5) for place in range(69)]
    game = SyntheticGame({"nodes": names, "footholds": ["h0"], "edges": edges}).content()
    run = RunFolder.create(tmp_path / "run", {"experiment": "security", "algorithm": "gsiirl"}, game)
    run.append_metrics(0, {"seed": np.array([0]), "iteration": np.array([0])})
    # All up to h64 are held, then h65 falls: bits 62 to 64, then 65, are the first of the second word.
    columns = {
        "seed": [0, 0],
        "trajectory": [0, 0],
        "step": [0, 1],
        "state": [2**62 - 1] * 2,
        "state_1": [0b111, 0b1111],
        "learner_action": [0, 0],
        "expert_action": [64, 65],
    }
    run.save_paths({name: np.array(column) for name, column in columns.items()})
    path = pick_sample_path(RecordedGraph.read(game, run.path), ReportedRun.read(run.path))
    assert path is not None
    assert [step.outcome for step in path.steps] == ["taken", "unknown"]
    assert path.steps[0].fallen == {65}
    assert path.steps[0].compromised == set(range(66))
