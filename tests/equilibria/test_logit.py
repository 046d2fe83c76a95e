import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria import Logit, regularised_nash_gap, respond
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


@pytest.mark.parametrize("temperature", [0.4, 0.05])
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
