"""Players of a run earn in the environment what the run says that its policies earn."""

from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from pettingzoo_runs import continuous_run, finished, security_run

from gsiirl.errors import InputError
from gsiirl.experiments.config import ExperimentConfig
from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.game.config import GameConfig
from gsiirl.experiments.runner import run
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.games.rollout import play
from gsiirl.pettingzoo import Player, expert_player, learned_player, run_env
from gsiirl.pettingzoo.environment import GameEnv
from gsiirl.pettingzoo.stage import stage_of_config
from gsiirl.runs import RunFolder
from gsiirl.types import Sides


def returns(env: GameEnv, players: Sides[Player], episodes: int) -> np.ndarray:
    """Of both sides [episodes, 2]."""
    pair = dict(zip(env.possible_agents, (players.learner, players.expert), strict=True))
    random, earned = np.random.default_rng(0), np.zeros((episodes, 2))
    env.reset(seed=0)
    for episode in range(episodes):
        seen, _ = env.reset()
        while env.agents:
            seen, rewards, *_ = env.step({agent: player(seen[agent], random) for agent, player in pair.items()})
            earned[episode] += [*rewards.values()]
    return earned


def final(folder: RunFolder, pair: str, place: int) -> list[float]:
    """What a run says that a pair earns."""
    summary = folder.summary()
    assert summary is not None
    return [summary.final[f"{pair}_return_{side}"].per_seed[place] for side in ("learner", "expert")]


def assert_agree(measured: np.ndarray, expected: list[float], other_episodes: float = np.inf) -> None:
    """Within four standard errors."""
    error = measured.std(axis=0, ddof=1) * np.sqrt(1 / len(measured) + 1 / other_episodes)
    assert np.all(np.abs(measured.mean(axis=0) - expected) < 4 * error), (measured.mean(axis=0), expected, error)


@pytest.mark.parametrize("seed", [3, 4])
def test_a_defender_and_its_true_attacker_earn_what_the_run_says_is_deployed(seed: int, tmp_path: Path):
    folder, _ = security_run(tmp_path / "run", graph="small-linear", horizon=6)
    players = Sides(learned_player(tmp_path / "run", "defender", seed), expert_player(tmp_path / "run", seed))
    measured = returns(run_env(tmp_path / "run"), players, 300)
    assert_agree(measured, final(folder, "deployed", seed - 3))
    other = final(folder, "deployed", 4 - seed)
    assert abs(measured.mean(axis=0)[0] - other[0]) > 4 * measured.std(axis=0)[0] / 300**0.5, "seeds are told apart"


def test_the_attacker_as_learned_is_the_runs_own_model_of_it(tmp_path: Path):
    folder, _ = security_run(tmp_path / "run", graph="small-linear", horizon=2)
    policies = folder.load_policies()
    assert policies is not None
    player: Any = learned_player(tmp_path / "run", "attacker")
    random, begin = np.random.default_rng(0), run_env(tmp_path / "run").reset(seed=0)[0]["attacker"]
    drawn = np.bincount([player(begin, random) for _ in range(3000)], minlength=17) / 3000
    np.testing.assert_allclose(drawn, policies["expert.table"][0, 0, 0], atol=0.04)


@pytest.mark.parametrize(
    "config",
    [pytest.param(CrossingConfig(seeds=2, horizon=4), marks=pytest.mark.slow), DeceptionConfig(seeds=2, horizon=4)],
    ids=lambda config: config.experiment,
)
def test_networks_do_in_the_environment_what_they_do_in_the_package(
    config: CrossingConfig | DeceptionConfig, tmp_path: Path
):
    policies = continuous_run(tmp_path / "run", config).load_policies()
    env = run_env(tmp_path / "run")
    learner = learned_player(tmp_path / "run", env.possible_agents[0], 1)
    experts = learned_player(tmp_path / "run", env.possible_agents[1], 1), expert_player(tmp_path / "run", 1)
    assert policies is not None
    for player, name in zip((learner, *experts), ("learner", "expert", "response"), strict=True):
        first, _ = player.policy.layers[0]  # pyright: ignore[reportAttributeAccessIssue]
        np.testing.assert_array_equal(first, policies[f"{name}.layers.0.weight"][1])
    made, random, earned = stage_of_config(config, None).experiment, np.random.default_rng(0), []
    assert isinstance(made, ContinuousExperiment)
    for expert in experts:
        seen, _ = env.reset(seed=0)
        start, total = env.current, np.zeros(2)
        while env.agents:
            actions = dict(zip(env.agents, (learner, expert), strict=True))
            seen, rewards, *_ = env.step({agent: player(seen[agent], random) for agent, player in actions.items()})
            total += [*rewards.values()]
        with jax.enable_x64(False):
            networks = Sides(*(_traced(player) for player in (learner, expert)))
            episode = play(made.problem.game, networks, start)
            expected = [float(jnp.sum(jax.vmap(reward)(episode))) for reward in jax.tree.leaves(made.true_rewards)]
        assert total == pytest.approx(expected, abs=1e-4)
        earned.append(total)
    assert np.abs(earned[0] - earned[1]).max() > 1e-3


def _traced(player: Any) -> Any:
    """A network's policy as `play` takes it."""

    def policy(observation: jax.Array, time: jax.Array) -> jax.Array:
        value = jnp.append(observation, time)
        for weight, bias in player.policy.layers:
            value = jnp.tanh(jnp.asarray(weight) @ value + bias)
        return value

    return policy


def test_the_first_seed_that_did_not_fail_plays_where_none_is_named(tmp_path: Path):
    folder, _ = security_run(tmp_path / "run", failed=3, horizon=2)
    player, policies = learned_player(tmp_path / "run", "defender"), folder.load_policies()
    assert policies is not None
    np.testing.assert_array_equal(player.table, policies["learner.table"][1])  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises(InputError, match=r"seed: 3 is none of .*; choose from 4"):
        learned_player(tmp_path / "run", "defender", 3)


def test_a_run_that_cannot_play_is_refused_in_one_line(tmp_path: Path):
    folder, _ = security_run(tmp_path / "run", horizon=2)
    with pytest.raises(InputError, match="agent: cannot be 'robot'; choose defender or attacker"):
        learned_player(tmp_path / "run", "robot")
    policies = folder.load_policies()
    assert policies is not None
    folder.save_policies({name: table[:, :1] for name, table in policies.items()})
    with pytest.raises(InputError, match=r"policies.safetensors: is damaged .*learner.table is of shape"):
        learned_player(tmp_path / "run", "defender")
    (tmp_path / "run" / "summary.json").unlink()
    with pytest.raises(InputError, match=r"holds a run that is not finished; run .*resume"):
        expert_player(tmp_path / "run")
    config = GameConfig(preset="classic").resolved()
    finished(tmp_path / "game", config, {}, {}, deployed_return_learner=np.zeros(config.seeds))
    with pytest.raises(InputError, match="is a run of game, which has no environment; give a run of security"):
        run_env(tmp_path / "game")


SMALL: list[ExperimentConfig] = [
    SecurityConfig(graph_seed=2, nodes=3, edges=4, horizon=3, seeds=1, iterations=2, trajectories=20),
    CrossingConfig(algorithm="marl", seeds=1, horizon=10, hidden=8, training_steps=50, judging_steps=20),
]


@pytest.mark.slow
@pytest.mark.usefixtures("optax_promotion")
@pytest.mark.parametrize("config", SMALL, ids=lambda config: config.experiment)
def test_the_players_of_a_real_run_earn_what_its_summary_says(config: ExperimentConfig, tmp_path: Path):
    run(config, tmp_path / "run", lambda *_: None)
    folder, env = RunFolder.open(tmp_path / "run"), run_env(tmp_path / "run")
    exact = config.experiment == "security"
    learner, model = (learned_player(tmp_path / "run", agent) for agent in env.possible_agents)
    true = expert_player(tmp_path / "run")
    for pair, expert in (("deployed", true), ("model", model)):
        measured = returns(env, Sides(learner, expert), 300)
        assert_agree(measured, final(folder, pair, 0), np.inf if exact else 1000)
