"""The episode that is shown is a typical one."""

from pathlib import Path

import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.report.crossing.encounter_figure import smallest_distance
from gsiirl.report.deception.recorded_episode import BODIES, advantage, targets
from gsiirl.report.plane.episode import PlaneEpisode, pick_episode
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs import RunFolder

STEPS = 4


def episode_of(folder: Path, apart: list[float], failed: bool = False) -> PlaneEpisode | None:
    """Of recorded encounters in which the two keep a distance each; all of one seed."""
    run = RunFolder.create(folder / "run", {"experiment": "crossing", "algorithm": "gsiirl"}, {"name": "g"})
    returns = {
        "deployed_return_learner": np.array([-9.0 if failed else -1.0]),
        "random_return_learner": np.array([-5.0]),
    }
    run.append_metrics(0, {"seed": np.array([7]), "iteration": np.array([0]), **returns})
    trajectory, step = (each.ravel() for each in np.indices((len(apart), STEPS)))
    places = {"robot_x": 0.1 * step, "robot_y": 0.0 * step, "human_x": 0.1 * step, "human_y": np.repeat(apart, STEPS)}
    run.save_paths({"seed": np.full(len(step), 7), "trajectory": trajectory, "step": step, **places})
    return pick_episode(ReportedRun.read(run.path), ("robot", "human"), smallest_distance)


def test_the_encounter_in_the_middle_is_picked(tmp_path: Path) -> None:
    episode = episode_of(tmp_path, [0.9, 0.1, 0.4, 0.3, 0.2])
    assert episode is not None
    assert (episode.seed, episode.trajectory, episode.recorded, episode.steps) == (7, 3, 5, STEPS - 1)
    assert smallest_distance(episode) == pytest.approx(0.3)
    np.testing.assert_allclose(episode.positions["human"], [[0.1 * step, 0.3] for step in range(STEPS)])


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e101])
def test_an_episode_that_is_not_finite_is_damage(tmp_path: Path, value: float) -> None:
    with pytest.raises(InputError, match=r"paths.parquet: is damaged: it holds what is no number"):
        episode_of(tmp_path, [0.5, value])


def test_a_failed_seed_has_no_episode_to_show(tmp_path: Path) -> None:
    assert episode_of(tmp_path, [0.3, 0.4], failed=True) is None


def test_a_missing_column_is_named(tmp_path: Path) -> None:
    run = RunFolder.create(tmp_path / "run", {"experiment": "crossing", "algorithm": "gsiirl"}, {"name": "g"})
    run.append_metrics(0, {"seed": np.array([0]), "iteration": np.array([0])})
    run.save_paths({name: np.array([0]) for name in ("seed", "trajectory", "step", "robot_x")})
    with pytest.raises(InputError, match=r"paths.parquet: is damaged: it has no column robot_y"):
        pick_episode(ReportedRun.read(run.path), ("robot", "human"), smallest_distance)


def test_the_agents_advantage_is_measured_at_their_own_target() -> None:
    places = {"adversary": (0.0, 3.0), "agent_0": (0.0, 1.0), "agent_1": (5.0, 5.0)}
    places |= {"landmark_0": (9.0, 9.0), "landmark_1": (0.0, 0.0)}
    assert places.keys() == set(BODIES)
    positions = {body: np.array([place, place]) for body, place in places.items()}
    episode = PlaneEpisode(0, 0, 1, positions, {"target": 1.0, "expert_target": 0.0})
    assert targets(episode) == (1, 0)
    assert advantage(episode) == pytest.approx(3.0 - 1.0)
