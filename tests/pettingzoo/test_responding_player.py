"""The true expert answers whom it is used to."""

from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from pettingzoo_runs import continuous_run, security_run

from gsiirl.errors import InputError
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.security.problem import SecurityProblem
from gsiirl.pettingzoo import expert_player, learned_player, parallel_env, responding_player
from gsiirl.pettingzoo.players import NetworkPlayer, TablePlayer
from gsiirl.pettingzoo.stage import stage


def test_an_attacker_used_to_random_play_is_the_soft_best_response_to_it():
    settings: dict[str, Any] = {"nodes": 3, "edges": 4, "horizon": 3}
    player = responding_player("security", **settings)
    assert isinstance(player, TablePlayer)
    made = stage("security", settings)
    assert isinstance(made.experiment, SecurityProblem)
    with jax.enable_x64(True):
        reward = np.asarray(made.experiment.truth.rewards.expert.dense())
    assert reward.shape == (player.table.shape[1], 4, 4)
    # By hand, backwards: at the last step only the step's reward counts.
    values = reward.mean(axis=1) / made.experiment.truth.temperature
    expected = np.exp(values - values.max(axis=1, keepdims=True))
    np.testing.assert_allclose(player.table[-1], expected / expected.sum(axis=1, keepdims=True), atol=1e-10)


def test_an_attacker_used_to_a_runs_defender_is_the_runs_expert(tmp_path: Path):
    security_run(tmp_path / "run", nodes=3, edges=4, horizon=3)
    defender = learned_player(tmp_path / "run", "defender")
    used = responding_player("security", to=defender, nodes=3, edges=4, horizon=3)
    np.testing.assert_allclose(used.table, expert_player(tmp_path / "run").table)  # pyright: ignore
    with pytest.raises(InputError, match="to: is no policy of a defender in this game"):
        responding_player("security", to=defender, nodes=3, edges=4, horizon=4)


@pytest.mark.slow
@pytest.mark.usefixtures("optax_promotion")
def test_a_human_practises_against_the_robot_that_it_is_to_meet(tmp_path: Path):
    config = CrossingConfig(seeds=1, horizon=4)
    continuous_run(tmp_path / "run", config)
    robot = learned_player(tmp_path / "run", "robot")
    settings: dict[str, Any] = {"horizon": 4, "hidden": 5, "batch": 4, "judging_steps": 16}
    alone, used, again = (responding_player("crossing", to=to, **settings) for to in (None, robot, robot))
    env = parallel_env("crossing", horizon=4)
    seen, random = env.reset(seed=0)[0]["human"], np.random.default_rng(0)
    actions = [player(seen, random) for player in (alone, used, again)]
    assert env.action_space("human").contains(actions[1])
    np.testing.assert_array_equal(actions[1], actions[2])
    assert np.abs(actions[0] - actions[1]).max() > 1e-4
    assert isinstance(used, NetworkPlayer)
    with pytest.raises(InputError, match="to: is no policy of the learner in this game"):
        responding_player("deception", to=robot)
