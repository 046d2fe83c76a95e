from itertools import product

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.special import logsumexp

from gsiirl.equilibria.soft_joint import SoftJoint, joint_occupancy
from gsiirl.types import Sides
from tests import helpers, oracles

TEMPERATURE = 0.3


def solve(dense: oracles.Game, temperature: float):
    game = helpers.tabular_game(dense)
    return game, SoftJoint(temperature).solve(game, helpers.rewards_of(dense), helpers.DISCOUNT)


def soft_policy(dense: oracles.Game, temperature: float) -> tuple[np.ndarray, np.ndarray]:
    """Eq. 5-7 on all pairs of actions as one list, in plain numpy: the joint policy and the soft values."""
    states, learner_actions, expert_actions, _ = dense.transition.shape
    transition = dense.transition.reshape(states, -1, states)
    reward = (dense.learner_reward + dense.expert_reward).reshape(states, -1)
    values, policies, all_values = np.zeros(states), [], []
    for _ in range(helpers.HORIZON):
        action_values = reward + helpers.DISCOUNT * transition @ values
        values = temperature * np.asarray(logsumexp(action_values / temperature, axis=1))
        policies.insert(0, np.exp((action_values - values[:, None]) / temperature))
        all_values.insert(0, values)
    return np.stack(policies).reshape(-1, states, learner_actions, expert_actions), np.stack(all_values)


def random_joint(seed: int, horizon: int, dense: oracles.Game) -> np.ndarray:
    """A joint policy of shape (T, S, A_l, A_e) that does not factor."""
    shape = horizon, *dense.learner_reward.shape
    return np.random.default_rng(seed).dirichlet(np.ones(shape[2] * shape[3]), size=shape[:2]).reshape(shape)


@pytest.mark.parametrize("seed", range(3))
def test_policy_and_values_agree_with_a_plain_recursion(seed):
    dense = oracles.random_game(seed, 4, 3, 2)
    _, solution = solve(dense, TEMPERATURE)
    policy, values = soft_policy(dense, TEMPERATURE)
    np.testing.assert_allclose(solution.joint, policy, rtol=1e-12)
    np.testing.assert_allclose(solution.values, values, rtol=1e-12)
    np.testing.assert_allclose(solution.policies.learner, policy.sum(axis=3), rtol=1e-12)
    np.testing.assert_allclose(solution.policies.expert, policy.sum(axis=2), rtol=1e-12)


def test_occupancy_agrees_with_the_enumeration_of_all_paths():
    dense = oracles.random_game(0, 2, 2, 2)
    horizon, discount = 3, 0.8
    joint = random_joint(1, horizon, dense)
    expected = np.zeros((horizon, 2, 2, 2))
    for path in product(product(range(2), repeat=3), repeat=horizon):
        probability = dense.initial[path[0][0]]
        for time, (state, learner, expert) in enumerate(path):
            probability *= joint[time, state, learner, expert]
            if time + 1 < horizon:
                probability *= dense.transition[state, learner, expert, path[time + 1][0]]
        for time, step in enumerate(path):
            expected[time][step] += discount**time * probability
    found = joint_occupancy(helpers.tabular_game(dense, horizon), jnp.asarray(joint), discount)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_occupancy_is_the_same_compiled_and_over_a_batch_of_policies():
    dense = oracles.random_game(3, 4, 3, 2)
    game = helpers.tabular_game(dense)
    joints = jnp.stack([jnp.asarray(random_joint(seed, helpers.HORIZON, dense)) for seed in range(3)])
    alone = jnp.stack([joint_occupancy(game, joint, helpers.DISCOUNT) for joint in joints])
    compiled = eqx.filter_jit(joint_occupancy)(game, joints[1], helpers.DISCOUNT)
    batched = jax.jit(jax.vmap(lambda joint: joint_occupancy(game, joint, helpers.DISCOUNT)))(joints)
    np.testing.assert_allclose(compiled, alone[1], rtol=1e-13)
    np.testing.assert_allclose(batched, alone, rtol=1e-13)


def test_at_low_temperature_both_sides_maximise_their_common_return():
    dense = oracles.random_game(5, 4, 3, 2)
    temperature = 1e-3
    game, solution = solve(dense, temperature)
    reward, values = dense.learner_reward + dense.expert_reward, np.zeros(4)
    for _ in range(helpers.HORIZON):
        values = (reward + helpers.DISCOUNT * dense.transition @ values).max(axis=(1, 2))
    occupancy = joint_occupancy(game, solution.joint, helpers.DISCOUNT)
    attained = float(jnp.sum(occupancy * jnp.asarray(reward)[None]))
    best = float(dense.initial @ values)
    # Entropy is worth at most τ ln(A_l A_e) a step.
    assert 0.0 <= best - attained <= temperature * helpers.HORIZON * np.log(6)


def test_opposed_rewards_cancel_and_both_sides_play_at_random():
    dense = oracles.random_game(6, 4, 3, 2)
    _, solution = solve(dense._replace(expert_reward=-dense.learner_reward), TEMPERATURE)
    np.testing.assert_allclose(solution.joint, 1 / 6, rtol=1e-13)


def test_the_joint_policy_does_not_factor_into_its_marginals():
    _, solution = solve(oracles.random_game(7, 4, 3, 2), TEMPERATURE)
    policies: Sides = solution.policies
    factored = policies.learner[..., :, None] * policies.expert[..., None, :]
    assert float(jnp.max(jnp.abs(factored - solution.joint))) > 0.01
