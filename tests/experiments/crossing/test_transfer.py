"""What was learned in the crossing is put to use in a changed one, and judged by the true rewards there."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import polars
import pytest

from gsiirl.cli import main
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.equilibria.policy_weights import weights_of
from gsiirl.experiments.config import config_to_dict
from gsiirl.experiments.crossing.changes import Layout
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.crossing.transfer import LearnedCrossing, Procedure, World, judged
from gsiirl.experiments.transfer.learned import Model
from gsiirl.games import Crossing
from gsiirl.rewards import crossing as rewards
from gsiirl.runs import RunFolder, summarise
from gsiirl.runs.files.json_file import read_versioned_json
from gsiirl.types import Sides, Transition

pytestmark = pytest.mark.usefixtures("optax_promotion")

SEEDS, HORIZON = [3, 4], 6
CONFIG = CrossingConfig(
    seeds=2,
    first_seed=3,
    horizon=HORIZON,
    hidden=16,
    batch=16,
    iterations=1,
    trajectories=4,
    training_steps=1000,
    judging_steps=40,
    learning_rate=0.01,
    evaluation_episodes=64,
).resolved()


NETWORKS = ("learner", "expert", "response")


def network(seed: int, name: str) -> PolicyNetwork:
    return PolicyNetwork.create(4, 2, CONFIG.hidden, jax.random.key(3 * seed + NETWORKS.index(name)))


def finished_run(
    path: Path, algorithm: str = "gsiirl", config: CrossingConfig = CONFIG, lost: int | None = None
) -> Path:
    """A run that ended with random weights and policies."""
    config = replace(config, algorithm=algorithm)
    folder = RunFolder.create(path, config_to_dict(config), {"kind": "crossing"})
    random = np.random.default_rng(0)
    own = "dependent_reward" if algorithm == "gsiirl" else "commitment"
    names = {own: rewards.RobotFeatures().names, "expert_reward": rewards.HumanFeatures().names}
    arrays = {name: random.normal(size=(2, len(each))).astype(np.float32) for name, each in names.items()}
    arrays = {name: each / np.linalg.norm(each, axis=1, keepdims=True) for name, each in arrays.items()}
    deployed = np.array([np.nan if seed == lost else 0.0 for seed in SEEDS], np.float32)
    arrays["expert_reward"] = arrays["expert_reward"] + deployed[:, None]
    folder.save_learned(arrays, dict.fromkeys(arrays, 1.0), names, SEEDS)
    kept = [weights_of(**{name: network(seed, name) for name in NETWORKS}) for seed in SEEDS]
    folder.save_policies({name: np.stack([np.asarray(each[name]) for each in kept]) for name in kept[0]})
    columns = {"seed": SEEDS, "iteration": [0, 0], "deployed_return_learner": deployed}
    folder.append_metrics(0, {name: np.asarray(each) for name, each in columns.items()})
    folder.write_summary(summarise(folder.config, polars.DataFrame(columns), completed=True))
    return path


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finished_run(tmp_path_factory.mktemp("transfer") / "run")


def straight_on(layout: Layout, starts: np.ndarray) -> np.ndarray:
    """Discounted returns of a robot that goes to its goal as fast as it can, with no human near: one an episode.

    Along each axis it comes nearer by up to its speed in a step, and then stays.
    """
    away = np.abs(starts - np.array(layout.robot_goal))
    steps = np.arange(1, HORIZON + 1)[:, None, None]
    distances = np.linalg.norm(np.maximum(away - layout.robot_speed * steps, 0.0), axis=-1)
    return -(CONFIG.discount ** np.arange(HORIZON)) @ distances


def test_without_a_change_the_crossing_is_that_of_the_experiment():
    world, game = World.of(Layout(), HORIZON), Crossing(HORIZON)
    state = game.reset(jax.random.key(0))
    actions = Sides(jnp.array([0.3, -1.0]), jnp.array([0.5, 0.2]))
    following = world.game.step(world.game.reset(jax.random.key(0)), actions)
    expected = game.step(state, actions)
    for side in ("learner", "expert"):
        np.testing.assert_allclose(
            getattr(following.positions, side), getattr(expected.positions, side), rtol=1e-6, atol=1e-7
        )
    seen = Transition(state, actions, expected)
    np.testing.assert_allclose(world.own_reward(seen), rewards.own_reward(seen), rtol=1e-6)


def test_a_change_moves_starts_speeds_and_the_goal():
    layout = Layout((0.2, 0.3), (0.5, 0.5), (-1.0, -2.0), 0.05, 0.2)
    world = World.of(layout, HORIZON)
    starts = jax.vmap(world.game.reset)(jax.random.split(jax.random.key(0), 200))
    np.testing.assert_allclose(jnp.mean(starts.positions.learner, axis=0), layout.robot_start, atol=0.05)
    np.testing.assert_allclose(jnp.mean(starts.positions.expert, axis=0), layout.human_start, atol=0.05)
    state = jax.tree.map(lambda leaf: leaf[0], starts)
    full = jnp.array([1.0, -1.0])
    moved = world.game.step(state, Sides(full, full))
    np.testing.assert_allclose(moved.positions.learner - state.positions.learner, 0.05 * full, atol=1e-6)
    np.testing.assert_allclose(moved.positions.expert - state.positions.expert, 0.2 * full, atol=1e-6)
    away = np.linalg.norm(np.asarray(moved.positions.learner) - np.array(layout.robot_goal))
    np.testing.assert_allclose(world.own_reward(Transition(state, Sides(full, full), moved)), -away, rtol=1e-5)


@pytest.mark.slow
def test_where_no_human_is_near_every_search_goes_straight_to_the_goal(run: Path):
    # The closed form shares no code with the package; the human is far away, and at full speed all along.
    layouts = [
        replace(Layout(human_start=(1.5, 1.0)), robot_goal=(0.3, -0.2), robot_speed=0.08),
        replace(Layout(human_start=(1.5, 1.0)), robot_start=(0.2, 0.1)),
    ]
    learned, procedure = LearnedCrossing.open(run), Procedure(CONFIG)
    # No r_ld that holds a far human dear, whatever it wants.
    learned = replace(learned, weights=Sides(np.zeros_like(learned.weights.learner), learned.weights.expert))
    beside = Sides(learned.weights.learner, -learned.weights.expert)
    for layout in layouts:
        found = judged(
            procedure,
            layout,
            learned,
            {"gsiirl": Model(learned.weights, learned.policies), "another": Model(beside, learned.policies)},
        )
        world = World.of(layout, HORIZON)
        key = jax.random.split(jax.random.key(1), 20_000)
        starts = np.asarray(jax.vmap(world.game.reset)(key).positions.learner)
        best, first = straight_on(layout, starts).mean(), straight_on(replace(layout, robot_speed=0.0), starts).mean()
        for name in ("true rewards", "gsiirl", "another", "clone", "own reward alone"):
            # As a share of what is between standing still and the best; the 64 episodes have other starts.
            missed = (best - found.returns[name][0]) / (best - first)
            assert missed.min() > -0.03, name
            assert missed.max() < 0.15, name
        assert found.returns["policy unchanged"][0].max() < best - 0.3 * (best - first)
        assert found.about["layout"]["robot_speed"] == layout.robot_speed
    # One compilation served both.
    assert procedure.committed._cache_size() == 1  # pyright: ignore[reportAttributeAccessIssue]
    assert procedure.worth._cache_size() == 1  # pyright: ignore[reportAttributeAccessIssue]


@pytest.mark.slow
def test_the_command_prints_every_change_and_writes_a_sealed_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    quick = replace(CONFIG, training_steps=4, judging_steps=4, evaluation_episodes=8)
    run, beside = (finished_run(tmp_path / name, name, quick) for name in ("gsiirl", "ma-irl"))
    changes = ["--change", "robot-goal=0.3:0.4", "--change", "human-speed=0.05"]
    assert main(["transfer", str(run), "--beside", str(beside), *changes, "--quiet"]) == 0
    printed = capsys.readouterr().out
    assert "robot-goal=0.3:0.4" in printed
    assert "own reward alone" in printed
    content = read_versioned_json(run / "transfer.json", "", carries=True)
    names = ["true rewards", "gsiirl", "ma-irl", "ma-irl, r_e alone", "clone", "policy unchanged"]
    for each, (field, value) in zip(
        content["changes"], [("robot_goal", [0.3, 0.4]), ("human_speed", 0.05)], strict=True
    ):
        assert list(each["rows"]) == [*names, "own reward alone", "random"]
        assert each["layout"][field] == value
        assert [len(row["regret"]["per_seed"]) for row in each["rows"].values()] == [2, 2, 2, 2, 2, 2, 1, 1]
        assert each["rows"]["true rewards"]["regret"]["mean"] == pytest.approx(0.0, abs=1e-6)
        assert each["rows"]["random"]["regret_percent"]["per_seed"] == pytest.approx([100.0], abs=1e-4)
    # The same again writes the same.
    assert main(["transfer", str(run), "--beside", str(beside), *changes, "--quiet"]) == 0
    assert read_versioned_json(run / "transfer.json", "", carries=True) == content


def test_learned_weights_and_networks_are_those_of_the_run(run: Path):
    learned = LearnedCrossing.open(run)
    assert (learned.seeds, learned.left_out, learned.algorithm) == (SEEDS, [], "gsiirl")
    np.testing.assert_allclose(np.linalg.norm(learned.weights.expert, axis=1), 1.0, rtol=1e-6)
    seen, time = jnp.array([0.1, -0.3, 0.2, 0.4], jnp.float32), jnp.asarray(0.5, jnp.float32)
    for name in NETWORKS:
        for row, seed in enumerate(SEEDS):
            one: Any = jax.tree.map(lambda leaf, row=row: leaf[row], learned.policies[name])
            np.testing.assert_array_equal(one(seen, time), network(seed, name)(seen, time))


def test_a_seed_whose_rewards_are_no_numbers_is_left_out(tmp_path: Path):
    learned = LearnedCrossing.open(finished_run(tmp_path / "run", lost=SEEDS[1]))
    assert (learned.seeds, learned.left_out) == (SEEDS[:1], SEEDS[1:])
    assert learned.weights.learner.shape[0] == learned.weights.expert.shape[0] == 1
    assert jax.tree.leaves(learned.policies["learner"])[0].shape[0] == 1


def test_runs_and_changes_that_do_not_fit_are_refused_in_one_line(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    other = finished_run(tmp_path / "other", config=replace(CONFIG, discount=0.5))
    wider = finished_run(tmp_path / "wider", config=replace(CONFIG, hidden=32))
    for arguments, line in [
        ([str(run), "--beside", str(other)], f"--beside: {other} is a run of another game; give one of the game of"),
        ([str(run), "--beside", str(wider)], f"--beside: {wider} is a run of another game; give one of the game of"),
        ([str(run), "--change", "redraw=1"], "--change: 'redraw=1' is no change of the crossing; give robot-goal=X:Y"),
        ([str(run), "--change", "human-speed=9"], "--change: human-speed cannot be 9; give a number above 0"),
    ]:
        assert main(["transfer", *arguments, "--quiet"]) == 2
        captured = capsys.readouterr()
        [said] = captured.err.splitlines()
        assert said.startswith(f"gsiirl: {line}")
        assert captured.out == ""
    assert not (run / "transfer.json").exists()
