import jax
import numpy as np
from problems import tiny_problem

from gsiirl.equilibria.response import respond
from gsiirl.experts.tabular_expert import RespondingExpert, SimulatedExpert
from gsiirl.irl.expectations import reward_gradient_expectation, sampled_reward_gradient
from gsiirl.types import Sides


def test_a_responding_expert_plays_its_soft_best_response():
    problem = tiny_problem(commitment="reward")
    learner, expert = problem.reward_learner, problem.expert
    assert isinstance(expert, RespondingExpert)
    played = learner.forward(learner.init(jax.random.key(0))).policies.learner
    answer = respond(problem.game, played, expert.reward, expert.temperature, expert.discount).policy
    np.testing.assert_array_equal(expert.policy(played), answer)
    reward = learner.expert_reward
    exact = reward_gradient_expectation(problem.game, reward, Sides(played, answer), 0.95)
    seen = expert.demonstrate(played, 20_000, jax.random.key(1))
    sampled = sampled_reward_gradient(reward, seen, 0.95, exact.dtype)
    # A trajectory's features are at most a step's features (norm <= sqrt(2)) times the horizon.
    standard_error = reward.scale * np.sqrt(2) * problem.game.horizon / np.sqrt(20_000)
    assert float(np.abs(sampled - exact).max()) <= 5 * standard_error


def test_a_simulated_expert_plays_the_equilibrium_of_what_it_is_told_and_of_its_own_reward():
    problem = tiny_problem(commitment="reward")
    learner, forward_model = problem.reward_learner, problem.truth.forward_model
    told = learner.propose(learner.init(jax.random.key(0))).reward
    expert = SimulatedExpert(problem.game, problem.expert.reward, forward_model, 0.95)
    policies = forward_model.solve(problem.game, Sides(told, problem.expert.reward), 0.95).policies
    reward = learner.expert_reward
    exact = reward_gradient_expectation(problem.game, reward, policies, 0.95)
    seen = expert.demonstrate_told(told, 20_000, jax.random.key(1))
    sampled = sampled_reward_gradient(reward, seen, 0.95, exact.dtype)
    standard_error = reward.scale * np.sqrt(2) * problem.game.horizon / np.sqrt(20_000)
    assert float(np.abs(sampled - exact).max()) <= 5 * standard_error
