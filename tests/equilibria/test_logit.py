from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from commitment_oracle import response
from small_games import finite_game, tabular

from gsiirl.equilibria import Logit, regularised_nash_gap, respond
from gsiirl.games import DensePayoff, TabularGame
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.irl.expectations import expected_return
from gsiirl.rewards import attack_graph as rewards
from gsiirl.rewards.linear import Linear
from gsiirl.scenarios import Variant, random_network
from gsiirl.types import Sides
from tests import helpers, oracles

DISCOUNT = 0.95
TEMPERATURES = [1.0, 0.4, 0.3, 0.1, 0.05, 0.02]


def security(seed: int, variant: Variant = "general_sum") -> tuple[AttackGraph, Sides]:
    network = random_network(seed, 8, 10, variant)
    game = AttackGraph.create(network, 10)
    return game, helpers.true_rewards(game, network)


@pytest.mark.parametrize("temperature", [1.0, 0.4, 0.15])
@pytest.mark.parametrize("seed", range(3))
def test_dense_games_agree_with_the_oracle(seed, temperature):
    dense = oracles.random_game(seed, 3, 3, 4)
    expected = oracles.markov_logit(dense, helpers.HORIZON, helpers.DISCOUNT, temperature)
    found = helpers.solve(helpers.tabular_game(dense), helpers.rewards_of(dense), temperature)
    assert bool(found.converged)
    np.testing.assert_allclose(found.policies.learner, expected.learner_policy, atol=1e-9)
    np.testing.assert_allclose(found.policies.expert, expected.expert_policy, atol=1e-9)
    np.testing.assert_allclose(found.values.learner, expected.learner_value[:-1], atol=1e-9)
    np.testing.assert_allclose(found.values.expert, expected.expert_value[:-1], atol=1e-9)
    np.testing.assert_array_equal(found.branch_folds, expected.folded)


@pytest.mark.parametrize("temperature", [0.4, pytest.param(0.05, marks=pytest.mark.slow)])
def test_attack_graphs_agree_with_the_oracle(temperature):
    network, game, dense = helpers.small_attack_graph()
    expected = oracles.markov_logit(dense.game(), helpers.HORIZON, DISCOUNT, temperature)
    found = helpers.solve(game, helpers.true_rewards(game, network), temperature, DISCOUNT)
    np.testing.assert_allclose(found.policies.learner, expected.learner_policy, atol=1e-9)
    np.testing.assert_allclose(found.policies.expert, expected.expert_policy, atol=1e-9)


@eqx.filter_jit
def checks_of_an_equilibrium(game, true, temperature):
    """Residual, distance of the expert's half from its best response, and the regularised gap."""
    solution = Logit(temperature).solve(game, true, DISCOUNT)
    answer = respond(game, solution.policies.learner, true.expert, temperature, DISCOUNT)
    away = jnp.max(jnp.abs(answer.policy - solution.policies.expert))
    return solution.residual, away, regularised_nash_gap(game, true, solution.policies, DISCOUNT, temperature)


@pytest.mark.parametrize("variant", ["general_sum", "zero_sum"])
def test_residual_response_and_regularised_gap_vanish(variant):
    game, true = security(0, variant)
    for temperature in TEMPERATURES:
        residual, away, gap = checks_of_an_equilibrium(game, true, jnp.asarray(temperature))
        assert float(residual) <= 1e-10
        assert float(away) <= 1e-10
        assert abs(float(gap)) <= 1e-9


def test_implicit_gradients_agree_with_central_differences():
    network = random_network(1, 5, 7)
    game = AttackGraph.create(network, 5)
    true = helpers.true_rewards(game, network)
    commitment = Linear(rewards.commitment_features(game), 2.0)
    theta = np.asarray(commitment.initial_parameters(jax.random.key(0), jnp.dtype(float)))

    def objective(parameters, temperature):
        solution = Logit(temperature).solve(game, Sides(commitment.payoff(parameters), true.expert), DISCOUNT)
        return expected_return(game, true.learner, solution.policies, DISCOUNT)

    value, derivatives = jax.jit(objective), jax.jit(jax.grad(objective, (0, 1)))
    for temperature in (1.0, 0.4, 0.1):
        found, found_temperature = derivatives(jnp.asarray(theta), jnp.asarray(temperature))
        expected = oracles.return_gradient_by_differences(
            lambda x, at=temperature: float(value(jnp.asarray(x), jnp.asarray(at))), theta
        )
        assert np.linalg.norm(found - expected) <= 1e-6 * np.linalg.norm(expected)
        [expected_temperature] = oracles.return_gradient_by_differences(
            lambda x: float(value(jnp.asarray(theta), jnp.asarray(x[0]))), np.array([temperature])
        )
        assert float(found_temperature) == pytest.approx(expected_temperature, rel=1e-6)


def test_a_batch_of_games_is_the_same_as_one_by_one():
    game, true = security(3)
    scaled = [jax.tree.map(lambda leaf, k=k: (1.0 + 0.3 * k) * leaf, true) for k in range(3)]
    solve = jax.jit(lambda one: Logit(0.1).solve(game, one, DISCOUNT).policies)
    together = jax.jit(jax.vmap(solve))(jax.tree.map(lambda *leaves: jnp.stack(leaves), *scaled))
    for k, one in enumerate(scaled):
        np.testing.assert_allclose(together.learner[k], solve(one).learner, atol=1e-11)


def test_single_precision_converges_to_its_own_tolerance():
    with jax.enable_x64(False):
        game, true = security(0)
        solution = helpers.solve(game, true, 0.4, DISCOUNT)
        assert solution.policies.learner.dtype == jnp.float32
        assert bool(solution.converged)


def test_forbidden_actions_are_those_of_a_game_without_them():
    # Actions 1 of the learner and 0 of the expert are forbidden everywhere: what is left is a smaller game.
    dense = oracles.random_game(0, 3, 3, 4)
    game, true = helpers.tabular_game(dense), helpers.rewards_of(dense)
    kept = np.array([0, 2]), np.array([1, 2, 3])
    masks = [np.isin(np.arange(size), each) for size, each in zip((3, 4), kept, strict=True)]
    masked = TabularGame.from_arrays(
        (np.asarray(game.successors), np.asarray(game.probabilities)),
        initial=dense.initial,
        horizon=helpers.HORIZON,
        learner_actions=np.tile(masks[0], (3, 1)),
        expert_actions=np.tile(masks[1], (3, 1)),
    )
    rows = np.ix_(np.arange(3), *kept)
    smaller = TabularGame.from_arrays(
        (np.asarray(game.successors)[rows], np.asarray(game.probabilities)[rows]),
        initial=dense.initial,
        horizon=helpers.HORIZON,
    )
    found = helpers.solve(masked, true, 0.15)
    expected = helpers.solve(smaller, jax.tree.map(lambda leaf: leaf[rows], true), 0.15)
    assert bool(found.converged)
    for side, mask in zip(("learner", "expert"), masks, strict=True):
        policy = getattr(found.policies, side)
        np.testing.assert_allclose(policy[..., mask], getattr(expected.policies, side), atol=1e-9)
        np.testing.assert_array_equal(policy[..., ~mask], 0.0)
        np.testing.assert_allclose(getattr(found.values, side), getattr(expected.values, side), atol=1e-9)


def test_every_side_may_have_masks_of_its_own_in_every_state():
    game = finite_game()
    rewards = Sides(
        DensePayoff(jnp.asarray(game.dependent + game.own[..., None])), DensePayoff(jnp.asarray(game.expert))
    )
    found = helpers.solve(tabular(game), rewards, game.temperature, game.discount)
    assert bool(found.converged)
    # Each answers the other softly: the expert by the oracle's response, the learner by that of the game turned round.
    policies = jax.tree.map(np.asarray, found.policies)
    np.testing.assert_allclose(policies.expert[:, :2], response(game, policies.learner)[:, :2], atol=1e-9)
    turned = replace(
        game,
        transitions=game.transitions.swapaxes(1, 2),
        expert=(game.dependent + game.own[..., None]).swapaxes(1, 2),
        learner_actions=game.expert_actions,
        expert_actions=game.learner_actions,
    )
    np.testing.assert_allclose(policies.learner[:, :2], response(turned, policies.expert)[:, :2], atol=1e-9)
