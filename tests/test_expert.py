import jax
import numpy as np
from problems import tiny_problem

from gsiirl.equilibria.response import respond
from gsiirl.irl.expectations import reward_gradient_expectation, sampled_reward_gradient
from gsiirl.types import Sides


def test_a_responding_expert_plays_its_soft_best_response():
    problem = tiny_problem()
    learner, expert = problem.learner, problem.expert
    played = learner.propose(learner.init(jax.random.key(0))).policies.learner
    answer = respond(problem.game, played, expert.reward, expert.temperature, expert.discount).policy
    np.testing.assert_array_equal(expert.policy(played), answer)
    reward = learner.bilevel.expert_reward
    exact = reward_gradient_expectation(problem.game, reward, Sides(played, answer), 0.95)
    seen = expert.demonstrate(played, 20_000, jax.random.key(1))
    sampled = sampled_reward_gradient(reward, seen, 0.95, exact.dtype)
    # A trajectory's features are at most a step's features (norm <= sqrt(2)) times the horizon.
    standard_error = reward.scale * np.sqrt(2) * problem.game.horizon / np.sqrt(20_000)
    assert float(np.abs(sampled - exact).max()) <= 5 * standard_error
