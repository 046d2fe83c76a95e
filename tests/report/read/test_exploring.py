"""Interactions that are played to explore are left out of curves; algorithms are told apart."""

from pathlib import Path

import numpy as np
from report.synthetic import group_of
from report.synthetic_plane import LITTLE, write_plane_run

from gsiirl.runs import RunFolder


def test_curves_leave_out_what_is_played_to_see_more(plane_runs: dict[str, list[Path]]) -> None:
    run = group_of(plane_runs["crossing"]).of("gsiirl")
    assert run is not None
    earned, rates = run.curve("deployed_return_learner"), run.curve("collision_rate")
    assert earned is not None
    assert rates is not None
    assert run.metrics["deployed_return_learner"].min() == LITTLE
    assert earned.mean.min() > LITTLE / 2
    assert earned.iteration.tolist() == rates.iteration.tolist() == [0, 1, 3, 4, 6, 7, 9, 10]


def test_captions_are_silent_and_curves_whole_where_nobody_explores(tmp_path: Path) -> None:
    folder = write_plane_run(tmp_path / "run", "crossing", "gsiirl", exploring=False)
    group = group_of([folder.path])
    assert group.exploring == ""
    run = group.of("gsiirl")
    assert run is not None
    curve = run.curve("deployed_return_learner")
    assert curve is not None
    assert curve.iteration.tolist() == list(range(11))


def test_marl_solved_by_maddpg_is_known_by_its_solver(tmp_path: Path) -> None:
    run = RunFolder.create(
        tmp_path / "run", {"experiment": "deception", "algorithm": "marl", "solver": "maddpg"}, {"name": "g"}
    )
    run.append_metrics(0, {"seed": np.array([0]), "iteration": np.array([0])})
    assert list(group_of([run.path]).runs) == ["MARL (MADDPG)"]
