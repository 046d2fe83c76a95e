"""What was learned on one network is put to use on a changed one, and judged by the true rewards there."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import numpy as np
import polars
import pytest
from commitment_oracle import FiniteGame, extremes, learner_return

from gsiirl.cli import main
from gsiirl.commitment import anew
from gsiirl.errors import InputError
from gsiirl.experiments.config import config_to_dict
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.security.changes import changed
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.security.transfer import SEEN, Learned, World, judged, kept_where_same
from gsiirl.experiments.transfer.learned import Model
from gsiirl.experiments.transfer.regret import rows
from gsiirl.rewards import attack_graph as rewards
from gsiirl.runs import RunFolder, summarise
from gsiirl.runs.files.json_file import read_versioned_json
from gsiirl.scenarios import AttackNetwork
from tests import oracles
from tests.helpers import small_network

SEEDS, HORIZON, TEMPERATURE = [3, 4], 2, 0.2
CHANGE = "remove-edge=c:d"
CONFIG = SecurityConfig(
    seeds=2, first_seed=3, horizon=HORIZON, temperature=TEMPERATURE, nodes=4, edges=6, iterations=1, trajectories=10
).resolved()


def names_of(network: AttackNetwork) -> dict[str, list[str]]:
    nodes, edges = network.node_names, network.edge_names
    attack = [f"value of {node}" for node in nodes] + [f"cost of {edge}" for edge in edges]
    loss = [f"loss of {node}" for node in nodes] + [
        f"{kind} of {edge}" for kind in ("share", "block") for edge in edges
    ]
    return {"expert_reward": attack, "dependent_reward": loss, "commitment": loss}


def finished_run(
    path: Path,
    algorithm: str = "gsiirl",
    expert: np.ndarray | None = None,
    dependent: np.ndarray | None = None,
    config: SecurityConfig = CONFIG,
    lost: int | None = None,
) -> Path:
    """A run on the small network that ended with the true rewards, or others, and with policies drawn at random."""
    network = small_network()
    config = replace(config, algorithm=algorithm)
    world = World.of(network, config, TEMPERATURE)
    folder = RunFolder.create(path, config_to_dict(config), {**network.to_json_dict()})
    true = {
        "expert_reward": rewards.expert_weights(network) if expert is None else expert,
        "dependent_reward": rewards.dependent_weights(network) if dependent is None else dependent,
    }
    if algorithm == "ma-irl":
        true["commitment"] = true.pop("dependent_reward")
    arrays = {name: np.tile(weights, (2, 1)) for name, weights in true.items()}
    scales = dict.fromkeys(arrays, 1.0)
    deployed = [np.nan if seed == lost else 0.0 for seed in SEEDS]
    arrays["expert_reward"] = arrays["expert_reward"] + np.array(deployed)[:, None]
    names = {name: each for name, each in names_of(network).items() if name in arrays}
    random, states = np.random.default_rng(0), world.game.number_of_states
    columns = {"seed": SEEDS, "iteration": [0, 0], "deployed_return_learner": deployed}
    folder.append_metrics(0, {name: np.asarray(each) for name, each in columns.items()})
    folder.save_learned(arrays, scales, names, SEEDS)
    folder.save_policies({"learner.table": random.dirichlet(np.ones(6), size=(2, HORIZON, states))})
    if algorithm == "gsiirl":
        folder.save_checkpoint({SEEN: 50 * random.dirichlet(np.full(6, 0.2), (2, 1, HORIZON, states))}, 1, 1)
    folder.write_summary(summarise(folder.config, polars.DataFrame(columns), completed=True))
    return path


@pytest.fixture(scope="module", autouse=True)
def short_search() -> Iterator[None]:
    """A part of the search is enough for so small a game."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(anew, "is_small", lambda game: False)
        yield


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finished_run(tmp_path_factory.mktemp("transfer") / "run")


@pytest.fixture(scope="module")
def beside(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run whose attacker wants nothing."""
    return finished_run(tmp_path_factory.mktemp("beside") / "run", "ma-irl", expert=np.zeros(10))


@pytest.fixture(scope="module")
def found(run: Path, beside: Path) -> dict[str, Any]:
    """The rows of a change."""
    result = Learned.open(run).transferred([CHANGE], Learned.open(beside, "--beside"), quiet=True)
    return result["changes"][0]["rows"]


def dense(network: AttackNetwork) -> FiniteGame:
    """The network as the oracle of commitments knows it, over all 2^N states."""
    game = oracles.attack_graph_dense(network)
    return FiniteGame(
        name=network.name,
        transitions=game.transition,
        initial=game.initial,
        horizon=HORIZON,
        own=game.own_reward[:, :, 0],
        dependent=game.dependent_reward,
        expert=game.expert_reward,
        discount=CONFIG.discount,
        temperature=TEMPERATURE,
    )


def over_all_states(policy: np.ndarray, network: AttackNetwork) -> np.ndarray:
    """A policy over the states that can be reached, as one over all; uniform elsewhere."""
    masks = np.asarray(World.of(network, CONFIG, TEMPERATURE).game.masks)
    every = np.full((HORIZON, 2 ** len(network.node_names), policy.shape[-1]), 1.0 / policy.shape[-1])
    every[:, masks] = policy
    return every


def test_the_procedure_with_the_true_rewards_finds_the_best_commitment_of_the_changed_game(found: dict[str, Any]):
    ceiling, _, floor = extremes(dense(changed(small_network(), CHANGE)), starts=48)
    value = found["true rewards"]["discounted_return"]["mean"]
    assert value == pytest.approx(ceiling, abs=2e-4 * (ceiling - floor))


def test_who_learned_the_true_rewards_regrets_nothing(found: dict[str, Any]):
    assert found["gsiirl"]["regret"]["per_seed"] == [0.0, 0.0]
    assert found["ma-irl"]["regret"]["mean"] > 1e-3
    # Its losses are the true ones: the attacker that it takes for one without aims is all that is wrong.
    assert found["ma-irl, r_e alone"] == found["ma-irl"]


def test_random_play_regrets_all(found: dict[str, Any]):
    assert found["random"]["regret_percent"]["mean"] == pytest.approx(100.0)
    assert found["true rewards"]["regret_percent"]["per_seed"] == [0.0]


def test_the_old_policy_is_played_where_states_and_edges_are_the_same(run: Path, found: dict[str, Any]):
    network = changed(small_network(), CHANGE)
    policies = Learned.open(run).policies
    # The edge that is gone is the fourth; three of c's successors can no longer be reached without it.
    before = np.asarray(World.of(small_network(), CONFIG, TEMPERATURE).game.masks)
    after = np.asarray(World.of(network, CONFIG, TEMPERATURE).game.masks)
    kept = np.delete(policies, 3, axis=-1)[:, :, np.searchsorted(before, after)]
    kept /= kept.sum(-1, keepdims=True)
    expected = [learner_return(dense(network), over_all_states(each, network)) for each in kept]
    np.testing.assert_allclose(found["policy unchanged"]["discounted_return"]["per_seed"], expected, atol=1e-12)
    undiscounted = [learner_return(dense(network), over_all_states(each, network), 1.0) for each in kept]
    np.testing.assert_allclose(found["policy unchanged"]["return"]["per_seed"], undiscounted, atol=1e-12)


def test_where_nothing_changes_the_old_policies_earn_what_they_earned(run: Path):
    learned = Learned.open(run)
    with jax.numpy_dtype_promotion("standard"):
        models = dict.fromkeys(["gsiirl", "another"], Model(learned.weights, learned.policies))
        found = rows(judged(learned, learned.network, models).returns)
    expected = [
        learner_return(dense(learned.network), over_all_states(each, learned.network)) for each in learned.policies
    ]
    np.testing.assert_allclose(found["policy unchanged"]["discounted_return"]["per_seed"], expected, atol=1e-12)
    assert found["gsiirl"]["regret"]["per_seed"] == [0.0, 0.0]


def test_searches_are_counted_as_they_end(run: Path):
    learned, told = Learned.open(run), []
    with jax.numpy_dtype_promotion("standard"):
        models = {"gsiirl": Model(learned.weights, learned.policies)}
        judged(learned, learned.network, models, lambda done, of: told.append((done, of)))
    assert told == [(0, 3), (1, 3), (2, 3), (3, 3)]


def test_the_clone_is_met_with_the_best_answer_to_what_was_seen(run: Path, found: dict[str, Any]):
    network = changed(small_network(), CHANGE)
    game, checkpoint = dense(network), RunFolder.open(run).load_checkpoint()
    before = np.asarray(World.of(small_network(), CONFIG, TEMPERATURE).game.masks)
    assert checkpoint is not None
    earned = []
    for seen in checkpoint.arrays[SEEN][:, 0].sum(axis=1):
        clone = np.ones((len(game.initial), 6))
        clone[before] = np.where(seen.sum(-1, keepdims=True) > 0, seen, 1.0)
        clone = np.delete(clone, 3, axis=-1)
        clone /= clone.sum(-1, keepdims=True)
        value, policy = np.zeros(len(game.initial)), []
        for _ in range(HORIZON):
            gain = game.own[:, :, None] + game.dependent + CONFIG.discount * game.transitions @ value
            merit = np.einsum("sab,sb->sa", gain, clone)
            policy.append(np.eye(5)[merit.argmax(-1)])
            value = merit.max(-1)
        earned.append(learner_return(game, np.array(policy[::-1])))
    np.testing.assert_allclose(found["clone"]["discounted_return"]["per_seed"], earned, atol=1e-12)


def test_what_is_new_or_left_with_nothing_is_uniform():
    without, network = (
        World.of(each, CONFIG, TEMPERATURE).game
        for each in (changed(changed(small_network(), "remove-edge=a:c"), "remove-edge=outside:c"), small_network())
    )
    table = np.zeros((without.number_of_states, 4))
    table[:, 0] = 2.0
    # From a and b alone nothing but a -> b and b -> d can be attacked, and c never falls.
    assert without.number_of_states < network.number_of_states
    policy = kept_where_same(table, without, network, "expert")
    same = np.isin(np.asarray(network.masks), np.asarray(without.masks))
    np.testing.assert_array_equal(policy[same], np.tile(np.eye(6)[0], (same.sum(), 1)))
    np.testing.assert_array_equal(policy[~same], np.full(((~same).sum(), 6), 1 / 6))
    gone = changed(small_network(), "remove-edge=a:b")
    only = np.tile(np.eye(6)[0], (network.number_of_states, 1))
    back = kept_where_same(only, network, World.of(gone, CONFIG, TEMPERATURE).game, "expert")
    np.testing.assert_array_equal(back, np.full(back.shape, 1 / 5))


def test_a_side_that_may_do_nothing_goes_on_doing_nothing():
    config = replace(CONFIG, learner_no_op=True)
    before, after = (
        World.of(each, config, TEMPERATURE).game for each in (small_network(), changed(small_network(), CHANGE))
    )
    idle = np.tile(np.eye(7)[-1], (before.number_of_states, 1))
    np.testing.assert_array_equal(
        kept_where_same(idle, before, after, "learner"), np.tile(np.eye(6)[-1], (after.number_of_states, 1))
    )


@pytest.mark.parametrize(
    ("algorithm", "temperature", "unit"),
    [("gsiirl", TEMPERATURE, TEMPERATURE), ("gsiirl", "unknown", 1.0), ("ma-irl", "unknown", 0.4)],
)
def test_rewards_are_read_in_units_of_the_temperature(algorithm: str, temperature: object, unit: float, tmp_path: Path):
    config = replace(CONFIG, temperature=temperature)
    run = finished_run(tmp_path / "run", algorithm, config=config)
    true = rewards.expert_weights(small_network())
    np.testing.assert_allclose(Learned.open(run).weights.expert, np.tile(true / unit, (2, 1)))


def test_the_command_prints_every_change_and_writes_a_sealed_file(
    run: Path, beside: Path, found: dict[str, Any], capsys: pytest.CaptureFixture[str]
):
    changes = ["--change", CHANGE, "--change", "redraw=1"]
    assert main(["transfer", str(run), "--beside", str(beside), *changes, "--quiet"]) == 0
    printed = capsys.readouterr().out
    assert f"{CHANGE}, " in printed
    assert "regret in per cent, all seeds and 2 changes" in " ".join(printed.split())
    assert printed.splitlines()[-1] == str(run / "transfer.json")
    content = read_versioned_json(run / "transfer.json", "", carries=True)
    assert [each["change"] for each in content["changes"]] == [CHANGE, "redraw=1"]
    assert content["changes"][0]["rows"] == found
    regrets = [each["rows"]["clone"]["regret_percent"]["per_seed"] for each in content["changes"]]
    assert content["all_changes"]["clone"]["mean"] == pytest.approx(np.mean(regrets))
    assert content["all_changes"]["clone"]["worst"] == np.max(regrets)


def finished_deception(path: Path) -> Path:
    """A run of a game that has no changes yet."""
    folder = RunFolder.create(path, config_to_dict(DeceptionConfig(seeds=1).resolved()), {"kind": "deception"})
    folder.save_learned({"expert_reward": np.ones((1, 1))}, {"expert_reward": 1.0}, {"expert_reward": ["far"]}, [0])
    folder.save_policies({"learner.layers.0.weight": np.ones((1, 2, 2))})
    columns = {"seed": [0], "iteration": [0]}
    folder.write_summary(summarise(folder.config, polars.DataFrame(columns), completed=True))
    return path


def test_other_runs_are_refused_in_one_line(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    deception = finished_deception(tmp_path / "deception")
    unfinished = tmp_path / "unfinished"
    RunFolder.create(unfinished, config_to_dict(CONFIG), dict(small_network().to_json_dict()))
    other = finished_run(tmp_path / "other", config=replace(CONFIG, discount=0.5))
    for arguments, line in [
        ([str(deception)], f"DIR: {deception} is a run of deception; give the folder of a finished run of"),
        ([str(unfinished)], f"DIR: {unfinished} holds a run that is not finished; run "),
        (
            [str(run), "--beside", str(other)],
            f"--beside: {other} is a run of another game; give one of the game of {run}",
        ),
        ([str(run), "--change", "grow"], "--change: 'grow' is no change of a network; give remove-edge=A:B"),
        ([str(run), "--changes", "0"], "--changes: cannot be 0; give a whole number of at least 1"),
        ([str(run), "--change-seed", "x"], "--change-seed: cannot be x; give a whole number of at least 0"),
    ]:
        assert main(["transfer", *arguments]) == 2
        captured = capsys.readouterr()
        [said] = captured.err.splitlines()
        assert said.startswith(f"gsiirl: {line}")
        assert captured.out == ""


def test_a_run_without_learned_rewards_is_refused(run: Path, tmp_path: Path):
    config = replace(CONFIG, algorithm="marl")
    folder = RunFolder.create(tmp_path / "marl", config_to_dict(config), dict(small_network().to_json_dict()))
    columns = {"seed": SEEDS, "iteration": [0, 0]}
    folder.write_summary(summarise(folder.config, polars.DataFrame(columns), completed=True))
    with pytest.raises(InputError, match="is a run of marl, which keeps no learned reward; give the folder"):
        Learned.open(tmp_path / "marl")


def test_a_seed_whose_rewards_are_no_numbers_is_left_out(tmp_path: Path):
    run = finished_run(tmp_path / "run", lost=SEEDS[0])
    learned = Learned.open(run)
    assert (learned.seeds, learned.left_out) == (SEEDS[1:], SEEDS[:1])
    assert learned.weights.expert.shape == (1, 10)
    assert learned.policies.shape[0] == len(learned.answers) == 1  # pyright: ignore[reportArgumentType]
