import jax
import jax.numpy as jnp
import numpy as np
import pytest
from problems import tiny_problem

from gsiirl.baselines.marl import marl
from gsiirl.games.rollout import rollout
from gsiirl.irl.expectations import reward_gradient_expectation
from gsiirl.types import Sides

pytestmark = pytest.mark.usefixtures("optax_promotion")


def test_marl_is_the_forward_model_at_both_true_rewards():
    problem = tiny_problem()
    solution = marl(problem.game, problem.truth.rewards, problem.learner.forward_model, 0.95)
    references = problem.truth.references()
    returns = problem.truth.returns(solution.policies)
    np.testing.assert_allclose(returns.learner, references["truth_return_learner"], atol=1e-12)
    np.testing.assert_allclose(returns.expert, references["truth_return_expert"], atol=1e-12)


def test_feature_matching_closes_the_gap_to_the_demonstrations():
    problem = tiny_problem(inner_steps=5, inner_step_size=0.01)
    ma_irl = problem.ma_irl
    true_play = marl(problem.game, problem.truth.rewards, problem.learner.forward_model, 0.95).policies
    keys = jax.random.split(jax.random.key(1), 5000)
    seen = jax.vmap(lambda key: rollout(key, problem.game, true_play))(keys)

    @jax.jit
    def gaps(state):
        policies = ma_irl.propose(state).policies
        return jnp.stack(
            [
                jnp.linalg.norm(reward_gradient_expectation(problem.game, reward, policies, 0.95) - demonstrated)
                for reward, demonstrated in (
                    (ma_irl.rewards.learner, state.demonstrated.learner),
                    (ma_irl.rewards.expert, state.demonstrated.expert),
                )
            ]
        )

    state = ma_irl.init(jax.random.key(0), seen)
    before = gaps(state)
    many = jax.jit(lambda state: jax.lax.fori_loop(0, 60, lambda _, s: ma_irl.update(s), state))
    after = gaps(many(state))
    assert np.all(after < 0.15 * before)


def test_the_truth_is_nearly_a_fixed_point():
    problem = tiny_problem(inner_steps=1, inner_step_size=1e-3)
    true_play = marl(problem.game, problem.truth.rewards, problem.learner.forward_model, 0.95).policies
    rewards = problem.ma_irl.rewards
    for reward, name in ((rewards.learner, "dependent_reward"), (rewards.expert, "expert_reward")):
        weights = jnp.asarray(problem.true_weights[name])
        assert float(jnp.linalg.norm(weights)) <= reward.scale
    solution = problem.learner.forward_model.solve(
        problem.game,
        Sides(
            rewards.learner.payoff(jnp.asarray(problem.true_weights["dependent_reward"]) / rewards.learner.scale)
            + problem.ma_irl.own_reward,
            rewards.expert.payoff(jnp.asarray(problem.true_weights["expert_reward"]) / rewards.expert.scale),
        ),
        0.95,
    )
    np.testing.assert_allclose(solution.policies.learner, true_play.learner, atol=1e-12)
