import dataclasses
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest
from problems import tiny_config, tiny_problem

from gsiirl.baselines.ma_irl import MAIRLState
from gsiirl.baselines.marl import marl
from gsiirl.experiments.security import run
from gsiirl.games.rollout import rollout
from gsiirl.irl.expectations import reward_gradient_expectation
from gsiirl.learners.commitment_learner import Incumbent
from gsiirl.types import Sides

pytestmark = pytest.mark.usefixtures("optax_promotion")


@pytest.mark.slow
def test_marl_is_the_forward_model_at_both_true_rewards():
    problem = tiny_problem()
    solution = marl(problem.game, problem.truth.rewards, problem.truth.forward_model, 0.95)
    references = problem.truth.references()
    returns = problem.truth.returns(solution.policies)
    np.testing.assert_allclose(returns.learner, references["truth_return_learner"], atol=1e-12)
    np.testing.assert_allclose(returns.expert, references["truth_return_expert"], atol=1e-12)


def test_the_demonstrations_show_how_marl_plays_the_true_game(monkeypatch):
    config, problem = tiny_config(algorithm="ma-irl").resolved(), tiny_problem(algorithm="ma-irl")
    edges, shape = problem.game.number_of_edges, (config.horizon, problem.game.number_of_states)
    # A pair that can be told from every other: edge 1 is blocked, and edge 3 attacked.
    blocks, attacks = (jnp.broadcast_to(jnp.eye(edges)[edge], (*shape, edges)) for edge in (1, 3))
    played = Incumbent(Sides(blocks, attacks), jnp.zeros(()), jnp.asarray(True))
    monkeypatch.setattr(run, "marl", lambda _, rewards, *others: {id(problem.truth.rewards): played}[id(rewards)])
    judged: Any = None
    shown = jax.jit(run._ma_irl(config, problem, judged).init)(jax.random.key(0)).demonstrated
    steps = np.sum(config.discount ** np.arange(config.horizon))
    for found, reward, does in (
        (shown.learner, problem.ma_irl.rewards.learner, np.eye(edges)[1]),
        (shown.expert, problem.ma_irl.rewards.expert, -np.eye(edges)[3]),
    ):
        np.testing.assert_allclose(found[-edges:], reward.scale * steps * does, rtol=1e-12)


@pytest.mark.slow
def test_feature_matching_closes_the_gap_to_the_demonstrations():
    problem = tiny_problem(inner_steps=5, inner_step_size=0.01)
    ma_irl = problem.ma_irl
    true_play = marl(problem.game, problem.truth.rewards, problem.truth.forward_model, 0.95).policies
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


def test_the_truth_is_a_fixed_point_for_exact_demonstrations_of_the_true_game():
    problem = tiny_problem(inner_steps=5)
    descent = optax.sgd(0.1)
    ma_irl = dataclasses.replace(problem.ma_irl, regularisation=0.0, optimiser=descent)
    true_play = marl(problem.game, problem.truth.rewards, problem.truth.forward_model, 0.95).policies
    rewards = ma_irl.rewards
    truth = Sides(
        jnp.asarray(problem.true_weights["dependent_reward"]) / rewards.learner.scale,
        jnp.asarray(problem.true_weights["expert_reward"]) / rewards.expert.scale,
    )
    exact = Sides(
        reward_gradient_expectation(problem.game, rewards.learner, true_play, 0.95),
        reward_gradient_expectation(problem.game, rewards.expert, true_play, 0.95),
    )
    update = eqx.filter_jit(ma_irl.update)

    def moved(demonstrated: Sides) -> float:
        after = update(MAIRLState(truth, demonstrated, descent.init((truth.learner, truth.expert)))).parameters
        return max(
            float(jnp.abs(after.learner - truth.learner).max()), float(jnp.abs(after.expert - truth.expert).max())
        )

    assert moved(exact) <= 1e-12
    assert moved(Sides(exact.learner, 1.1 * exact.expert)) >= 1e-4
