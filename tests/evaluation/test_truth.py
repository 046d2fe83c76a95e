import jax.numpy as jnp
import numpy as np
import oracles
from jaxtyping import Array
from problems import tiny_problem

from gsiirl.experiments.security.problem import SecurityProblem
from gsiirl.rewards.linear import Linear
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


def test_the_true_parameters_leave_no_feature_gap_and_lose_no_likelihood():
    problem, reward, theta, played = at_the_truth()
    right, opposite = (problem.truth.misfit(played, reward, each) for each in (theta, -theta))
    assert float(right["feature_gap"]) <= 1e-12
    assert abs(float(right["log_likelihood_lost"])) <= 1e-12
    assert float(opposite["feature_gap"]) > 0.1
    assert float(opposite["log_likelihood_lost"]) > 0.1


def test_lost_likelihood_is_the_expected_log_ratio_of_the_answers():
    problem, reward, theta, played = at_the_truth()
    truth, dense = problem.truth, oracles.attack_graph_dense(problem.network)
    game, masks = dense.game(), np.asarray(problem.game.masks)
    met = oracles.uniform_policy(len(played), dense.initial.size, played.shape[-1])
    met[:, masks] = np.asarray(played)

    def answer(factor: float) -> np.ndarray:
        expert_reward = factor * game.expert_reward
        return oracles.soft_best_response(game.transition, expert_reward, met, truth.discount, truth.temperature).policy

    expert, modelled = answer(1.0), answer(0.3)
    visits = oracles.occupancy(game.transition, game.initial, met, expert).sum(axis=2)
    expected = np.sum(visits * (np.log(expert) - np.log(modelled)))
    found = truth.misfit(played, reward, 0.3 * theta)["log_likelihood_lost"]
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert expected > 1e-3


def at_the_truth() -> tuple[SecurityProblem, Linear, Array, Array]:
    """A small problem, its expert's reward with the true parameters, and the learner's policy in equilibrium."""
    problem = tiny_problem()
    reward = problem.bilevel.expert_reward
    theta = jnp.asarray(problem.true_weights["expert_reward"]) / reward.scale
    played = problem.truth.forward_model.solve(problem.game, problem.truth.rewards, 0.95).policies.learner
    return problem, reward, theta, played
