"""Against a player, what is left is a game of one agent that keeps Gymnasium's rules."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from gsiirl.errors import InputError
from gsiirl.pettingzoo import against, parallel_env


def at_random(number: int) -> Any:
    return lambda observation, random: random.integers(number)


def security(horizon: int = 5) -> gymnasium.Env[Any, Any]:
    env = parallel_env("security", nodes=3, edges=4, horizon=horizon)
    return against(env, "defender", at_random(4))


def test_it_passes_gymnasiums_checks():
    with_drawn_actions, with_vectors = (
        security(),
        against(parallel_env("crossing", horizon=4), "robot", lambda observation, random: observation[2:4] / 4),
    )
    for env in (with_drawn_actions, with_vectors):
        check_env(env, skip_render_check=True, skip_close_check=True)


def test_rewards_and_observations_are_those_of_the_agent_that_is_left():
    both = parallel_env("security", nodes=3, edges=4, learner_no_op=True, horizon=5)
    alone = against(parallel_env("security", nodes=3, edges=4, learner_no_op=True, horizon=5), "defender", lambda *_: 4)
    assert alone.action_space == both.action_space("attacker")
    seen, _ = both.reset(seed=7)
    np.testing.assert_array_equal(alone.reset(seed=7)[0], seen["attacker"])
    for attack in (0, 1, 2, 3, 0):
        seen, rewards, _, over, _ = both.step({"attacker": attack, "defender": 4})
        alone_seen, reward, terminated, truncated, _ = alone.step(attack)
        np.testing.assert_array_equal(alone_seen, seen["attacker"])
        assert (reward, terminated, truncated) == (rewards["attacker"], False, over["attacker"])
    assert truncated


def test_a_seed_decides_what_the_player_draws_too():
    drawn: list[int] = []

    def player(observation: np.ndarray, random: np.random.Generator) -> int:
        drawn.append(int(random.integers(1000)))
        return 0

    env = against(parallel_env("security", nodes=3, edges=4), "defender", player)
    for seed in (1, 1, 2):
        env.reset(seed=seed)
        for _ in range(3):
            env.step(0)
    assert drawn[:3] == drawn[3:6]
    assert drawn[:3] != drawn[6:]


def test_an_agent_that_is_not_there_is_refused():
    with pytest.raises(InputError, match="agent: cannot be 'robot'; choose defender or attacker"):
        against(parallel_env("security", nodes=3, edges=4), "robot", at_random(4))
