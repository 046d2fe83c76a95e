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

TEMPERATURES = [1.0, 0.4, 0.3, 0.1, 0.05, 0.02]


def security(seed: int, variant: Variant = "general_sum"):
    network = random_network(seed, 8, 10, variant)
    game = AttackGraph.create(network, 10)
    learner = rewards.dependent_features(game).payoff(jnp.asarray(rewards.dependent_weights(network)))
    expert = rewards.attack_features(game).payoff(jnp.asarray(rewards.expert_weights(network)))
    return game, Sides(learner + rewards.own_reward(game, network), expert)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("temperature", [1.0, 0.4, 0.15])
def test_dense_games_agree_with_the_oracle(seed, temperature):
    dense = oracles.random_game(seed, 3, 3, 4)
    expected = oracles.markov_logit(dense, helpers.HORIZON, helpers.DISCOUNT, temperature)
    found = Logit(temperature).solve(helpers.tabular_game(dense), helpers.rewards_of(dense), helpers.DISCOUNT)
    assert bool(found.converged)
    np.testing.assert_allclose(found.policies.learner, expected.learner_policy, atol=1e-9)
    np.testing.assert_allclose(found.policies.expert, expected.expert_policy, atol=1e-9)
    np.testing.assert_allclose(found.values.learner, expected.learner_value[:-1], atol=1e-9)
    np.testing.assert_array_equal(found.branch_folds, expected.folded)


@pytest.mark.parametrize("temperature", [0.4, 0.05])
def test_attack_graphs_agree_with_the_oracle(temperature):
    network, game, dense = helpers.small_attack_graph()
    expected = oracles.markov_logit(dense.game(), helpers.HORIZON, 0.95, temperature)
    learner = rewards.dependent_features(game).payoff(jnp.asarray(rewards.dependent_weights(network)))
    expert = rewards.attack_features(game).payoff(jnp.asarray(rewards.expert_weights(network)))
    true = Sides(learner + rewards.own_reward(game, network), expert)
    found = Logit(temperature).solve(game, true, 0.95)
    np.testing.assert_allclose(found.policies.learner, expected.learner_policy, atol=1e-9)
    np.testing.assert_allclose(found.policies.expert, expected.expert_policy, atol=1e-9)


@pytest.mark.parametrize("variant", ["general_sum", "zero_sum"])
@pytest.mark.parametrize("temperature", TEMPERATURES)
def test_residual_response_and_regularised_gap_vanish(variant, temperature):
    game, true = security(0, variant)
    solution = Logit(temperature).solve(game, true, 0.95)
    assert float(solution.residual) <= 1e-10
    answer = respond(game, solution.policies.learner, true.expert, temperature, 0.95)
    assert float(jnp.max(jnp.abs(answer.policy - solution.policies.expert))) <= 1e-10
    assert abs(float(regularised_nash_gap(game, true, solution.policies, 0.95, temperature))) <= 1e-9


@pytest.mark.parametrize("temperature", [1.0, 0.4, 0.1])
def test_implicit_gradient_agrees_with_central_differences(temperature):
    game, true = security(1)
    commitment = Linear(rewards.commitment_features(game), 2.0)
    theta = commitment.initial_parameters(jax.random.key(0), jnp.dtype(float))

    @jax.jit
    def objective(parameters):
        solution = Logit(temperature).solve(game, Sides(commitment.payoff(parameters), true.expert), 0.95)
        return expected_return(game, true.learner, solution.policies, 0.95)

    found = jax.jit(jax.grad(objective))(theta)
    expected = oracles.return_gradient_by_differences(
        lambda x: float(objective(jnp.asarray(x))), np.asarray(theta), 1e-5
    )
    assert np.linalg.norm(found - expected) <= 1e-6 * np.linalg.norm(expected)


def test_gradient_in_the_temperature_agrees_with_central_differences():
    game, true = security(2)

    @jax.jit
    def objective(temperature):
        return expected_return(game, true.learner, Logit(temperature).solve(game, true, 0.95).policies, 0.95)

    found = float(jax.grad(objective)(jnp.asarray(0.4)))
    expected = float((objective(jnp.asarray(0.4 + 1e-5)) - objective(jnp.asarray(0.4 - 1e-5))) / 2e-5)
    assert abs(found - expected) <= 1e-6 * abs(expected)


def test_a_batch_of_games_is_the_same_as_one_by_one():
    game, true = security(3)
    scaled = [jax.tree.map(lambda leaf, k=k: (1.0 + 0.3 * k) * leaf, true) for k in range(3)]
    solver = Logit(0.1)
    batch = jax.tree.map(lambda *leaves: jnp.stack(leaves), *scaled)
    together = jax.jit(jax.vmap(lambda r: solver.solve(game, r, 0.95).policies))(batch)
    for k, one in enumerate(scaled):
        alone = jax.jit(lambda r: solver.solve(game, r, 0.95).policies)(one)
        np.testing.assert_allclose(together.learner[k], alone.learner, atol=1e-11)


def test_single_precision_converges_to_its_own_tolerance():
    with jax.enable_x64(False):
        game, true = security(0)
        solution = Logit(0.4).solve(game, true, 0.95)
        assert solution.policies.learner.dtype == jnp.float32
        assert bool(solution.converged)
