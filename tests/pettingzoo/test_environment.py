"""Environments keep PettingZoo's rules, and pay and do what the package's own games and rewards say."""

import warnings
from copy import deepcopy
from functools import cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import gsiirl
from gsiirl.errors import InputError
from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.pettingzoo import parallel_env
from gsiirl.pettingzoo.environment import GameEnv
from gsiirl.pettingzoo.stage import stage
from gsiirl.scenarios import random_network
from gsiirl.types import Sides, Transition

with warnings.catch_warnings():
    # PettingZoo's own tests import a game in a way that it warns of.
    warnings.simplefilter("ignore", DeprecationWarning)
    from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test
from pettingzoo.utils.conversions import parallel_to_aec

NETWORK = random_network(1, 5, 7, "general_sum")
SETTINGS: dict[str, dict[str, Any]] = {
    "security": {"graph_seed": 1, "nodes": 5, "edges": 7, "learner_no_op": True, "expert_no_op": True, "horizon": 6},
    "crossing": {"horizon": 4},
    "deception": {"horizon": 5, "variant": "separate_target"},
}
HARMLESS = [
    "ignore:Observation numpy array is all zeros",
    "ignore:We recommend agents to be named",
    "ignore:Agents have different",
    "ignore:Observations are different shapes",
]

each_game = pytest.mark.parametrize("experiment", SETTINGS)


@cache
def environment(experiment: str) -> GameEnv:
    return parallel_env(experiment, **SETTINGS[experiment])


def random_actions(env: GameEnv, random: np.random.Generator) -> dict[str, Any]:
    """Actions of both, drawn from their spaces."""
    for agent in env.possible_agents:
        env.action_space(agent).seed(int(random.integers(2**31)))
    return {agent: env.action_space(agent).sample() for agent in env.possible_agents}


def episode(env: GameEnv, seed: int) -> list[tuple[dict[str, Any], Any]]:
    """Actions and what `step` returned, of an episode of random play."""
    random = np.random.default_rng(seed)
    env.reset(seed=seed)
    steps = []
    while env.agents:
        actions = random_actions(env, random)
        steps.append((actions, env.step(actions)))
    return steps


@each_game
def test_environments_pass_the_parallel_api_test(experiment: str):
    parallel_api_test(environment(experiment), num_cycles=60)


@each_game
def test_environments_pass_the_parallel_seed_test(experiment: str):
    parallel_seed_test(partial(parallel_env, experiment, **SETTINGS[experiment]), num_cycles=20)


@each_game
@pytest.mark.filterwarnings(*HARMLESS)
def test_converted_to_turns_they_pass_the_api_test(experiment: str):
    api_test(parallel_to_aec(environment(experiment)), num_cycles=20)


@each_game
def test_an_episode_is_truncated_after_its_steps_and_never_terminated(experiment: str):
    env = environment(experiment)
    steps = episode(env, 0)
    assert len(steps) == SETTINGS[experiment]["horizon"]
    for number, (_, (seen, _, terminations, truncations, _)) in enumerate(steps, start=1):
        assert set(terminations.values()) == {False}
        assert set(truncations.values()) == {number == len(steps)}
        for agent in env.possible_agents:
            assert env.observation_space(agent).contains(seen[agent])
            assert seen[agent][-1] == np.float32(number) / np.float32(len(steps))
    with pytest.raises(InputError, match="call reset first"):
        env.step(steps[0][0])


@each_game
def test_without_a_seed_the_next_episode_is_another_and_the_last_seed_decides_which(experiment: str):
    env = environment(experiment)

    def two_episodes() -> list[float]:
        random, returns = np.random.default_rng(0), []
        for seed in (3, None):
            env.reset(seed=seed)
            returns.append(0.0)
            while env.agents:
                returns[-1] += sum(env.step(random_actions(env, random))[1].values())
        return returns

    first, second = two_episodes()
    assert first != second
    assert [first, second] == two_episodes()


def test_the_attack_graph_pays_what_is_computed_by_hand_from_the_network():
    env = environment("security")
    edges = len(NETWORK.edge_names)
    for seed in range(20):
        compromised = env.reset(seed=seed)[0]["defender"][:-1] > 0.5
        np.testing.assert_array_equal(np.flatnonzero(compromised), NETWORK.footholds)
        for actions, (seen, rewards, *_) in episode(env, seed):
            block, attack = actions["defender"], actions["attacker"]
            defender = 0.0 if block == edges else -NETWORK.block_cost[block]
            attacker, chance = 0.0, 0.0
            if attack < edges:
                source, target = NETWORK.edge_source[attack], NETWORK.edge_target[attack]
                if (source < 0 or compromised[source]) and not compromised[target] and block != attack:
                    chance = NETWORK.success_probability[attack]
                attacker = chance * NETWORK.value[target] - NETWORK.attack_cost[attack]
                defender -= chance * NETWORK.criticality[target]
            assert rewards == pytest.approx({"defender": defender, "attacker": attacker}, abs=1e-12)
            after = seen["attacker"][:-1] > 0.5
            np.testing.assert_array_equal(seen["attacker"], seen["defender"])
            new = np.flatnonzero(after != compromised)
            assert new.tolist() in ([], [NETWORK.edge_target[attack]] if chance else [])
            compromised = after


def test_attacks_succeed_as_often_as_the_network_says():
    env = environment("security")
    [entry] = [int(each) for each in np.flatnonzero(np.isin(NETWORK.edge_source, [-1, *NETWORK.footholds]))[:1]]
    chance, tries = NETWORK.success_probability[entry], 400
    actions = {"defender": len(NETWORK.edge_names), "attacker": entry}
    begun = np.array([env.reset(seed=seed)[0]["attacker"].sum() for seed in range(tries)])
    succeeded = 0
    for seed in range(tries):
        env.reset(seed=seed)
        succeeded += env.step(actions)[0]["attacker"][:-1].sum() > begun[seed]
    assert succeeded / tries == pytest.approx(chance, abs=4 * np.sqrt(chance * (1 - chance) / tries))


def test_an_attack_that_failed_may_succeed_when_it_is_tried_again():
    env = environment("security")
    [entry, *_] = np.flatnonzero(NETWORK.edge_source == NETWORK.footholds[0])
    fell = set()
    for seed in range(40):
        env.reset(seed=seed)
        held = [env.step({"defender": 7, "attacker": entry})[0]["attacker"][:-1].sum() for _ in range(6)]
        fell.add(held.index(max(held)))
    assert len(fell) >= 2


@pytest.mark.parametrize("experiment", ["crossing", "deception"])
def test_continuous_games_do_and_pay_what_the_packages_own_steps_and_rewards_do(experiment: str):
    env = environment(experiment)
    made = stage(experiment, SETTINGS[experiment])
    assert isinstance(made.experiment, ContinuousExperiment)
    game, rewards, names = made.experiment.problem.game, made.experiment.true_rewards, made.agents
    random = np.random.default_rng(0)
    for seed in range(5):
        env.reset(seed=seed)
        state = env.current
        while env.agents:
            actions = random_actions(env, random)
            seen, paid, *_ = env.step(actions)
            with jax.enable_x64(False):
                chosen = Sides(jnp.asarray(actions[names.learner]), jnp.asarray(actions[names.expert]))
                following = game.step(state, chosen)
                now = Transition(state, chosen, following)
                assert paid[names.learner] == pytest.approx(float(rewards.learner(now)), rel=1e-6, abs=1e-6)
                assert paid[names.expert] == pytest.approx(float(rewards.expert(now)), rel=1e-6, abs=1e-6)
                observed = game.observe(following)
            np.testing.assert_allclose(seen[names.learner][:-1], observed.learner, atol=1e-6)
            np.testing.assert_allclose(seen[names.expert][:-1], observed.expert, atol=1e-6)
            state = following


def test_the_adversary_of_a_separate_target_is_paid_for_the_other_landmark():
    env = environment("deception")
    seen, paid, *_ = episode(env, 0)[-1][1]
    landmarks = seen["adversary"][:4].reshape(2, 2)
    target = env.current.targets.learner
    assert paid["adversary"] == pytest.approx(-np.linalg.norm(landmarks[1 - target]), abs=1e-6)
    nearer = min(np.linalg.norm(each[:2]) for each in seen["good_agents"][:-1].reshape(2, 10))
    assert paid["good_agents"] == pytest.approx(np.linalg.norm(landmarks[target]) - nearer, abs=1e-6)


def test_a_push_beyond_the_largest_is_the_largest():
    env, seen = environment("crossing"), []
    for push in (1.0, 7.0):
        env.reset(seed=0)
        seen.append(env.step({"robot": np.array([push, -push]), "human": np.zeros(2)})[0]["robot"])
    np.testing.assert_array_equal(*seen)


@pytest.mark.parametrize(
    ("experiment", "actions", "told"),
    [
        ("security", {"defender": 8, "attacker": 0}, r"actions\['defender'\]: cannot be 8; give .* from 0 to 7"),
        ("security", {"defender": 0.5, "attacker": 0}, "give a whole number"),
        ("security", {"defender": 0}, "holds none of attacker"),
        ("crossing", {"robot": [0.0], "human": [0.0, 0.0]}, "give 2 numbers from -1 to 1"),
        ("crossing", {"robot": [0.0, 0.0], "human": [np.nan, 0.0]}, r"actions\['human'\]"),
    ],
)
def test_an_action_of_another_space_is_refused(experiment: str, actions: dict[str, Any], told: str):
    env = environment(experiment)
    env.reset(seed=0)
    with pytest.raises(InputError, match=told):
        env.step(actions)


@each_game
def test_a_copy_goes_on_as_its_original_does(experiment: str):
    env, random = environment(experiment), np.random.default_rng(0)
    env.reset(seed=5)
    env.step(random_actions(env, random))
    # Libraries copy environments where JAX's default precision holds.
    with jax.enable_x64(False):
        copy = deepcopy(env)
    while env.agents:
        actions = random_actions(env, random)
        (seen, rewards, *_), (copied_seen, copied_rewards, *_) = env.step(actions), copy.step(actions)
        assert rewards == copied_rewards
        for agent in env.possible_agents:
            np.testing.assert_array_equal(seen[agent], copied_seen[agent])
    assert copy.agents == []
    agent = env.possible_agents[0]
    np.testing.assert_array_equal(env.reset()[0][agent], copy.reset()[0][agent])


def test_gsiirl_knows_the_part_by_name():
    assert gsiirl.pettingzoo.parallel_env is parallel_env
