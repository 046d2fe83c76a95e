"""The conditional likelihood and its derivatives against sums spelled out in NumPy and against autodiff."""

from dataclasses import replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from commitment_oracle import Batch, Floats, response
from small_games import HORIZON, JOINT, expected_counts, finite_game, tabular

from gsiirl.irl.conditional_likelihood import ConditionalLikelihood, Seen
from gsiirl.irl.memory import Memory
from gsiirl.rewards.linear import IndicatorFeatures, TabularFeatures
from gsiirl.types import Sides, Trajectories

GAME = finite_game(3, temperature=1.0)
WEIGHTS = GAME.expert.ravel()
SHAPE = (HORIZON, JOINT[0], JOINT[2])


def likelihood(features: Any = None) -> ConditionalLikelihood:
    model = ConditionalLikelihood(tabular(GAME), features or IndicatorFeatures(shape=JOINT, names=()), GAME.discount)
    return jax.tree.map(jnp.asarray, model)


def some_policies(number: int) -> Floats:
    random = np.random.default_rng(5)
    return Batch(GAME).tidy(random.gamma(0.5, size=(number, HORIZON, *JOINT[:2])) + 1e-6)


def remembered(counts: list[Any], policies: Floats, capacity: int) -> Memory[Seen]:
    """A memory of these interactions, with slots left over."""
    nothing = Seen(jnp.asarray(policies[0]), jnp.zeros(SHAPE))
    memory = Memory.empty(capacity, nothing)
    for policy, each in zip(policies, counts, strict=True):
        memory = memory.remember(jax.random.key(0), Seen(jnp.asarray(policy), jnp.asarray(each)))
    return memory


@pytest.fixture(scope="module")
def counted() -> tuple[list[Any], Floats, Memory[Seen]]:
    """Three interactions of random counts in a memory of four."""
    random, policies = np.random.default_rng(6), some_policies(3)
    counts = [random.integers(0, 9, SHAPE) * (expected_counts(GAME, policy) > 0) * 1.0 for policy in policies]
    return counts, policies, remembered(counts, policies, 4)


def test_the_likelihood_is_the_sum_of_the_logarithms_of_what_was_chosen(counted) -> None:
    counts, policies, memory = counted
    expected = 0.0
    for each, policy in zip(counts, policies, strict=True):
        chosen = each > 0
        expected += (each[chosen] * np.log(response(GAME, policy)[chosen])).sum()
    np.testing.assert_allclose(eqx.filter_jit(likelihood().value)(jnp.asarray(WEIGHTS), memory), expected, rtol=1e-12)


def test_an_episode_tells_weights_apart_by_the_expected_logarithm_of_their_ratio() -> None:
    policy, others = some_policies(1)[0], WEIGHTS[::-1].copy()
    other = replace(GAME, expert=GAME.temperature * others.reshape(JOINT))
    truth, instead = response(GAME, policy), response(other, policy)
    counts = expected_counts(GAME, policy)
    seen = counts > 0
    expected = (counts[seen] * (np.log(truth[seen]) - np.log(instead[seen]))).sum()
    told = eqx.filter_jit(likelihood().discrimination)
    found = told(jnp.asarray(policy), jnp.asarray(WEIGHTS), jnp.asarray(others))
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    assert told(jnp.asarray(policy), jnp.asarray(WEIGHTS), jnp.asarray(WEIGHTS)) == 0.0


def test_the_derivatives_are_those_of_autodiff(counted) -> None:
    _, _, memory = counted
    model, weights = likelihood(), jnp.asarray(WEIGHTS)
    value, gradient = eqx.filter_jit(model.value_and_gradient)(weights, memory)
    np.testing.assert_allclose(value, eqx.filter_jit(model.value)(weights, memory), rtol=1e-12)
    np.testing.assert_allclose(gradient, eqx.filter_jit(model.gradient)(weights, memory), atol=1e-10)
    step = 1e-5
    for place in (0, 5, 11):
        up, down = (float(eqx.filter_jit(model.value)(weights.at[place].add(each), memory)) for each in (step, -step))
        np.testing.assert_allclose(gradient[place], (up - down) / (2 * step), atol=1e-6)


@pytest.mark.parametrize("features", ["every entry", "two of them"])
def test_the_fisher_information_is_minus_the_hessian_at_expected_counts(features: str) -> None:
    policies = some_policies(3)
    game = GAME
    model, weights = likelihood(), jnp.asarray(WEIGHTS)
    if features == "two of them":
        table = np.random.default_rng(8).normal(size=(*JOINT, 2))
        weights = jnp.array([0.7, -0.4])
        model = likelihood(TabularFeatures(table=table, names=()))
        game = replace(GAME, expert=table @ np.asarray(weights))
    memory = remembered([expected_counts(game, policy) for policy in policies], policies, 3)
    fisher = eqx.filter_jit(model.fisher)(weights, memory)
    hessian = jax.jit(jax.hessian(lambda theta: sum_of(model, theta, memory)))(weights)
    np.testing.assert_allclose(eqx.filter_jit(model.gradient)(weights, memory), 0.0, atol=1e-12)
    assert np.abs(hessian).max() > 0.01
    np.testing.assert_allclose(fisher, -hessian, rtol=0, atol=1e-9 * np.abs(hessian).max())


def sum_of(model: ConditionalLikelihood, weights: Any, memory: Memory[Seen]) -> Any:
    """The likelihood as a plain sum: autodiff cannot go backward through a loop of unknown length."""
    return jnp.sum(jax.vmap(lambda each: model.one_value(weights, each))(memory.kept))


def test_the_newest_interactions_have_a_fisher_information_of_their_own(counted) -> None:
    counts, policies, memory = counted
    fisher, weights = eqx.filter_jit(likelihood().fisher), jnp.asarray(WEIGHTS)
    for number in (1, 2):
        # Slot 0 holds the newest, slot 1 the oldest: that one was the first to be moved out of slot 0.
        places = [2, 0][:number]
        alone = remembered([counts[place] for place in places], policies[places], 4)
        np.testing.assert_allclose(fisher(weights, memory, jnp.asarray(number)), fisher(weights, alone), atol=1e-10)
    np.testing.assert_allclose(fisher(weights, memory, jnp.asarray(3)), fisher(weights, memory), atol=1e-10)
    np.testing.assert_array_equal(fisher(weights, memory, jnp.asarray(0)), 0.0)


def test_products_with_the_fisher_information_need_no_matrix(counted) -> None:
    _, _, memory = counted
    model, weights = likelihood(), jnp.asarray(WEIGHTS)
    fisher = eqx.filter_jit(model.fisher)(weights, memory)
    for seed in range(3):
        vector = jax.random.normal(jax.random.key(seed), weights.shape)
        found = eqx.filter_jit(model.fisher_times)(weights, vector, memory)
        np.testing.assert_allclose(found, fisher @ vector, atol=1e-11 * float(jnp.abs(fisher).max()))


def test_noise_of_the_data_has_the_fisher_information_for_its_covariance(counted) -> None:
    _, _, memory = counted
    model, weights, number = likelihood(), jnp.asarray(WEIGHTS), 20_000
    fisher = np.asarray(eqx.filter_jit(model.fisher)(weights, memory))
    keys = jax.random.split(jax.random.key(1), number)
    noise = np.asarray(jax.jit(lambda: jax.lax.map(lambda key: model.fisher_noise(weights, key, memory), keys))())
    # An entry's standard error is at most sqrt(2 F_ii F_jj / number).
    error = np.sqrt(2 * np.outer(np.diag(fisher), np.diag(fisher)) / number)
    assert (np.abs(noise.T @ noise / number - fisher) <= 5 * error + 1e-12).all()
    assert (np.abs(noise.mean(0)) <= 5 * np.sqrt(np.diag(fisher) / number) + 1e-12).all()


def test_what_the_mask_leaves_out_is_not_counted() -> None:
    states = jnp.array([[0, 1, 2], [1, 0, 0]])
    actions = Sides(jnp.zeros((2, HORIZON), int), jnp.array([[0, 2, 1], [1, 1, 0]]))
    mask = jnp.array([[True, True, False], [True, True, True]])
    seen = likelihood().seen(jnp.asarray(some_policies(1)[0]), Trajectories(states, actions, mask))
    expected = np.zeros(SHAPE)
    for time, state, action in [(0, 0, 0), (1, 1, 2), (0, 1, 1), (1, 0, 1), (2, 0, 0)]:
        expected[time, state, action] += 1
    np.testing.assert_array_equal(seen.counts, expected)
