import jax.numpy as jnp
import numpy as np
import oracles
from problems import tiny_problem

from gsiirl.types import Sides


def test_returns_are_undiscounted_sums_under_the_true_rewards():
    problem = tiny_problem()
    dense = oracles.attack_graph_dense(problem.network)
    masks = np.asarray(problem.game.masks)
    played = [oracles.random_policy(seed, 3, dense.initial.size, 5) for seed in (0, 1)]
    found = problem.truth.returns(Sides(*(jnp.asarray(policy[:, masks]) for policy in played)))
    game = dense.game()
    for value, reward in ((found.learner, game.learner_reward), (found.expert, game.expert_reward)):
        expected = oracles.policy_value(game.transition, game.initial, reward, played[0], played[1], 1.0)
        np.testing.assert_allclose(value, expected, atol=1e-12)


def test_at_the_true_equilibrium_model_and_deployment_agree():
    problem = tiny_problem()
    solution = problem.truth.forward_model.solve(problem.game, problem.truth.rewards, 0.95)
    record = problem.truth.evaluate(solution.policies)
    np.testing.assert_allclose(record["model_return_learner"], record["deployed_return_learner"], atol=1e-10)
    np.testing.assert_allclose(record["model_return_expert"], record["deployed_return_expert"], atol=1e-10)


def test_the_true_parameters_leave_no_feature_gap():
    problem = tiny_problem()
    reward = problem.bilevel.expert_reward
    theta = jnp.asarray(problem.true_weights["expert_reward"]) / reward.scale
    played = problem.truth.forward_model.solve(problem.game, problem.truth.rewards, 0.95).policies.learner
    assert float(problem.truth.feature_gap(played, reward, theta)) <= 1e-12
    assert float(problem.truth.feature_gap(played, reward, -theta)) > 0.1
