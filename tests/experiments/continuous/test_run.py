"""Both continuous games from the first iteration to the run folder, with tiny networks and few, short episodes."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria.pathwise import Pathwise, policies_of
from gsiirl.equilibria.policy_weights import weights_of
from gsiirl.evaluation.true_returns import TrueReturns
from gsiirl.experiments import runner
from gsiirl.experiments.continuous import run as run_module
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.crossing.problem import prepare
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.prepared_run import Algorithm
from gsiirl.front_door.continuous_fit import ContinuousGSIIRL
from gsiirl.games import Crossing
from gsiirl.games.rollout import episodes_from
from gsiirl.runs import RunFolder
from gsiirl.types import Sides, Transition

pytestmark = pytest.mark.usefixtures("optax_promotion")

TINY: dict[str, Any] = {
    "seeds": 2,
    "iterations": 3,
    "horizon": 4,
    "trajectories": 4,
    "inner_steps": 2,
    "first_inner_steps": 3,
    "compared": 3,
    "batch": 4,
    "solver_steps": 2,
    "response_steps": 2,
    "model_response_steps": 2,
    "settling_steps": 2,
    "training_steps": 4,
    "judging_steps": 4,
    "maddpg_episodes": 1,
    "evaluation_episodes": 8,
    "hidden": 4,
    "cloning_steps": 3,
}


def bytes_of(folder: Path) -> dict[str, bytes]:
    names = ("learned.safetensors", "policies.safetensors", "paths.parquet", "reward_map.parquet", "summary.json")
    files = [*sorted((folder / "metrics").iterdir()), *(folder / name for name in names)]
    return {path.name: path.read_bytes() for path in files}


@pytest.fixture(scope="module")
def crossing(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("crossing") / "run"
    runner.run(CrossingConfig(**TINY), folder)
    return folder


def keep_all(folder: Path) -> Path:
    # Tiny runs may end below an untrained learner; what they leave is asked for all the same.
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["completed"]
    return folder


@pytest.mark.slow
def test_a_run_of_the_crossing_records_what_its_report_shows(crossing):
    metrics = RunFolder.open(keep_all(crossing)).metrics()
    shown = {
        *(
            f"{kind}_return_{side}"
            for kind in ("model", "deployed", "truth", "random")
            for side in ("learner", "expert")
        ),
        *("collision_rate", "goal_rate_robot", "goal_rate_human", "human_goal_error"),
        *("truth_collision_rate", "truth_goal_rate_robot", "truth_goal_rate_human"),
        *("expert_reward_pearson", "expert_reward_epic", "dependent_reward_pearson", "expert_trajectories"),
        *("expert_reward_pearson_played", "feature_gap", "feature_gap_noise"),
        *("expert_reward_spearman", "expert_reward_starc", "expert_reward_epic_played"),
    }
    assert shown <= set(metrics.columns)
    assert metrics["iteration"].to_list() == [*range(4)] * 2
    for name in shown:
        assert np.isfinite(metrics[name].to_numpy()).all(), name
    assert metrics.filter(metrics["seed"] == 0)["expert_trajectories"].to_list() == [0.0, 4.0, 8.0, 12.0]


@pytest.mark.slow
def test_its_paths_are_whole_episodes_and_its_map_covers_the_arena(crossing):
    folder = RunFolder.open(crossing)
    paths, places = folder.paths(), folder.reward_map()
    assert paths is not None
    assert places is not None
    assert paths.filter((paths["seed"] == 0) & (paths["trajectory"] == 0))["step"].to_list() == [*range(5)]
    starts = paths.filter(paths["step"] == 0)
    assert np.max(starts["robot_y"].to_numpy()) <= -0.4
    assert (places["x"].min(), places["x"].max()) == pytest.approx((-0.8, 0.8))


@pytest.mark.slow
def test_an_interrupted_run_resumes_to_identical_bytes(crossing, tmp_path, monkeypatch):
    save = RunFolder.save_checkpoint

    def save_and_stop(*arguments: object) -> None:
        save(*arguments)  # pyright: ignore[reportArgumentType]
        raise KeyboardInterrupt

    monkeypatch.setattr(RunFolder, "save_checkpoint", save_and_stop)
    with pytest.raises(KeyboardInterrupt):
        runner.run(CrossingConfig(**TINY), tmp_path / "cut")
    monkeypatch.undo()
    runner.resume(tmp_path / "cut")
    assert bytes_of(tmp_path / "cut") == bytes_of(crossing)


def traced(config: CrossingConfig, function: Callable[[Algorithm, jax.Array], object]) -> None:
    """Go through what a run does without computing it, so that nothing of it is compiled."""
    with jax.enable_x64(False):
        run = prepare(config).algorithm
        jax.make_jaxpr(lambda key: function(run, key))(jax.random.key(0))


@pytest.mark.parametrize("algorithm", ["gsiirl", pytest.param("ma-irl", marks=pytest.mark.slow)])
def test_a_run_ends_with_what_its_forward_model_settles_on(algorithm, monkeypatch):
    pairs: list[Sides] = []

    def settled(_: object, solution: Sides, *others: object) -> Sides:
        pairs.append(jax.tree.map(jnp.negative, policies_of(solution)))
        return pairs[0]

    def end(run: Algorithm, key: jax.Array) -> None:
        policies = run.finish(run.init(key), key).policies
        [pair] = pairs
        for name, weight in weights_of(learner=pair.learner, expert=pair.expert).items():
            assert policies[name] is weight

    monkeypatch.setattr(ContinuousGSIIRL, "settled", settled)
    monkeypatch.setattr(TrueReturns, "best_response", lambda self, played, known, key: known[0])
    traced(CrossingConfig(**TINY, algorithm=algorithm).resolved(), end)


@pytest.mark.slow
def test_ma_irl_is_shown_how_marl_plays_the_true_game(monkeypatch):
    config, shown = CrossingConfig(**TINY, algorithm="ma-irl").resolved(), []

    def marl(self: TrueReturns, key: jax.Array) -> Sides:
        # By their width the networks are known again.
        return Pathwise.create(self.game, discount=0.9, batch=4, hidden=3, decay_steps=1).init(key)

    def episodes(game: Crossing, policies: Sides, starts: object) -> Transition:
        shown.append([each.layers[0].weight.shape[0] for each in (policies.learner, policies.expert)])
        return episodes_from(game, policies, starts)

    monkeypatch.setattr(TrueReturns, "marl", marl)
    monkeypatch.setattr(run_module, "episodes_from", episodes)
    traced(config, lambda run, key: run.advance(run.init(key), key, jnp.asarray(0), 1))
    assert shown == [[3, 3]]


@pytest.mark.slow
def test_marl_runs_to_its_end_and_says_how_far_it_can_be_exploited(tmp_path):
    runner.run(CrossingConfig(**TINY, algorithm="marl"), tmp_path / "run")
    summary = RunFolder.open(keep_all(tmp_path / "run")).summary()
    assert summary is not None
    assert summary.failed_seeds == []
    assert {"exploitability_learner", "exploitability_expert"} <= set(summary.final)
    final = summary.final
    assert final["truth_return_learner"] == final["model_return_learner"]
    # The expert's best response is what the learner meets when it is deployed.
    gain = final["deployed_return_expert"].mean - final["truth_return_expert"].mean
    assert final["exploitability_expert"].mean * abs(final["truth_return_expert"].mean) == pytest.approx(
        gain, rel=0.1, abs=1e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize("config", [CrossingConfig, DeceptionConfig])
@pytest.mark.parametrize(
    "changes",
    [
        {"algorithm": "paper"},
        {"algorithm": "ma-irl"},
        {"algorithm": "marl"},
        {"algorithm": "marl", "solver": "maddpg"},
        {"reward": "network"},
    ],
    ids=lambda changes: "-".join(changes.values()),
)
def test_every_algorithm_runs_to_its_end(config, changes, tmp_path):
    runner.run(config(**(TINY | changes)), tmp_path / "run")
    folder = RunFolder.open(tmp_path / "run")
    summary = folder.summary()
    assert summary is not None
    assert summary.completed
    metrics = folder.metrics().group_by("seed", maintain_order=True).last()
    for name in ("model_return_learner", "deployed_return_expert", "truth_return_learner"):
        assert np.isfinite(metrics[name].to_numpy()).all()


@pytest.mark.slow
def test_the_adversary_may_have_a_target_of_its_own(tmp_path):
    runner.run(DeceptionConfig(**TINY, variant="separate_target"), tmp_path / "run")
    paths = RunFolder.open(tmp_path / "run").paths()
    assert paths is not None
    assert (paths["target"] + paths["expert_target"]).unique().to_list() == [1.0]
