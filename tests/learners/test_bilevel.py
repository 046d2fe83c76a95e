"""Both levels of one random game: what `Bilevel` hands to the estimators, against dense numpy and differences."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.hypergradients import coordinate_jacobian
from gsiirl.irl.memory import Memory, Played
from gsiirl.learners.bilevel import Bilevel, LowerLevel
from gsiirl.theory.support.games import DISCOUNT, TEMPERATURE, RandomProblem, Size
from gsiirl.types import Policies
from tests import oracles

SIZE = Size(states=3, learner_actions=2, expert_actions=3, horizon=3, learner_parameters=2, expert_parameters=3)
REGULARISATION = 0.1
COMMITMENT = jnp.asarray([0.5, -0.4])
BELIEVED = jnp.asarray([0.1, 0.5, -0.3])
EXPERT = jnp.asarray([-0.2, 0.4, 0.3])
DEMONSTRATED = jnp.asarray([0.3, -0.1, 0.2])


class Found(NamedTuple):
    """What one problem says at (`COMMITMENT`, `EXPERT`), without λ in `hessian`, dG/dθ_e.

    `mixed`, `upper_mixed` are dG/dθ_l and d(∇_{θ_l} L)/dθ_e.
    """

    objective: jax.Array
    likelihood_gradient: jax.Array
    mixed: jax.Array
    hessian: jax.Array
    upper_mixed: jax.Array | None


@eqx.filter_jit
def evaluate(bilevel: Bilevel) -> Found:
    problem, size = bilevel.problem(BELIEVED, DEMONSTRATED), SIZE.learner_parameters

    def gradient(both: jax.Array) -> tuple[jax.Array, tuple[jax.Array, jax.Array]]:
        objective, likelihood_gradient = problem.evaluate(both[:size], both[size:])
        return likelihood_gradient, (objective, likelihood_gradient)

    second, (objective, likelihood_gradient) = jax.jacfwd(gradient, has_aux=True)(jnp.concatenate([COMMITMENT, EXPERT]))
    upper_gradient = problem.upper_gradient
    return Found(
        objective=objective,
        likelihood_gradient=likelihood_gradient,
        mixed=second[:, :size],
        hessian=second[:, size:],
        upper_mixed=None
        if upper_gradient is None
        else coordinate_jacobian(lambda theta: upper_gradient(COMMITMENT, theta), EXPERT, 1e-4),
    )


class Case(NamedTuple):
    """One lower level of the game, with the equilibria at `EXPERT` and, as played, at `BELIEVED`."""

    instance: RandomProblem
    bilevel: Bilevel
    policies: Policies
    played: Policies
    found: Found


@pytest.fixture(scope="module")
def equilibria() -> tuple[RandomProblem, Policies, Policies]:
    instance = RandomProblem.draw(3, SIZE)
    solve = jax.jit(lambda theta: instance.bilevel(REGULARISATION).solve(COMMITMENT, theta).policies)
    return instance, solve(EXPERT), solve(BELIEVED)


@pytest.fixture(scope="module", params=["played", "equilibrium"])
def case(request: pytest.FixtureRequest, equilibria: tuple[RandomProblem, Policies, Policies]) -> Case:
    level: LowerLevel = request.param
    instance, policies, played = equilibria
    bilevel = instance.bilevel(REGULARISATION, level)
    return Case(instance, bilevel, policies, played, evaluate(bilevel))


def dense(instance: RandomProblem) -> oracles.Game:
    """The game as dense numpy arrays, with the accessed values and r_li as the learner's reward."""
    game = instance.game
    states = np.eye(SIZE.states)
    # E[1{s' = k}] for every k is the transition's column k.
    transition = np.stack([np.asarray(game.continuation(jnp.asarray(state)).dense()) for state in states], axis=-1)
    return oracles.Game(
        transition=transition,
        learner_reward=np.asarray(instance.accessed + instance.own_reward),
        expert_reward=np.asarray(instance.true_expert_reward().values),
        initial=np.asarray(game.initial),
    )


def test_the_objective_is_the_return_under_the_accessed_values(case):
    game, policies = dense(case.instance), case.policies
    truth = oracles.policy_value(
        game.transition,
        game.initial,
        game.learner_reward,
        np.asarray(policies.learner),
        np.asarray(policies.expert),
        DISCOUNT,
    )
    assert case.found.objective == pytest.approx(truth, abs=1e-12)


def test_both_sides_act_on_the_parametric_rewards(equilibria):
    instance, policies, _ = equilibria
    game = dense(instance)._replace(
        learner_reward=np.asarray(instance.learner_features @ COMMITMENT + instance.own_reward),
        expert_reward=np.asarray(instance.expert_features @ EXPERT),
    )
    truth = oracles.markov_logit(game, SIZE.horizon, DISCOUNT, TEMPERATURE)
    assert np.allclose(policies.learner, truth.learner_policy, rtol=0.0, atol=1e-9)
    assert np.allclose(policies.expert, truth.expert_policy, rtol=0.0, atol=1e-9)


def test_the_lower_gradient_matches_features_of_the_policy_it_says(case):
    game, features = dense(case.instance), np.asarray(case.instance.expert_features)
    if case.bilevel.lower_level == "played":
        # The learner's half is played at what was believed, and is answered under θ_e.
        learner = np.asarray(case.played.learner)
        expert = oracles.soft_best_response(
            game.transition, features @ np.asarray(EXPERT), learner, DISCOUNT, TEMPERATURE
        ).policy
    else:
        learner, expert = np.asarray(case.policies.learner), np.asarray(case.policies.expert)
    occupancies = oracles.occupancy(game.transition, game.initial, learner, expert)
    modelled = oracles.feature_expectation(occupancies, features, DISCOUNT)
    likelihood = (modelled - np.asarray(DEMONSTRATED)) / TEMPERATURE
    assert np.allclose(case.found.likelihood_gradient, likelihood, rtol=0.0, atol=1e-10)


def test_the_lower_level_is_the_gradient_of_a_function_only_as_played(case):
    hessian, mixed = np.asarray(case.found.hessian), np.asarray(case.found.mixed)
    asymmetry = np.linalg.norm(hessian - hessian.T) / np.linalg.norm(hessian + hessian.T)
    if case.bilevel.lower_level == "equilibrium":
        assert case.found.upper_mixed is None
        assert asymmetry > 1e-3
        return
    # Second derivatives of one L are symmetric: in θ_e twice, and once in each of θ_l and θ_e.
    assert asymmetry <= 1e-12
    assert np.linalg.eigvalsh(hessian)[0] > 0.0
    assert np.allclose(case.found.upper_mixed, mixed.T, rtol=0.0, atol=1e-7)
    assert np.linalg.norm(mixed) > 0.01


def test_remembered_interactions_are_averaged_as_they_were_played(case):
    other = 0.5 * case.played.learner + 0.5 / SIZE.learner_actions
    memory = Memory.empty(4, Played(other, DEMONSTRATED))
    lower_gradient = eqx.filter_jit(lambda memory: case.bilevel.lower_gradient(COMMITMENT, EXPERT, memory))
    once = memory.remember(jax.random.key(0), Played(case.played.learner, DEMONSTRATED))
    expected = case.found.likelihood_gradient + REGULARISATION * EXPERT
    assert np.allclose(lower_gradient(once), expected, rtol=0.0, atol=1e-12)
    alone = lower_gradient(memory.remember(jax.random.key(0), Played(other, 2.0 * DEMONSTRATED)))
    both = lower_gradient(once.remember(jax.random.key(1), Played(other, 2.0 * DEMONSTRATED)))
    assert np.allclose(both, 0.5 * (expected + alone), rtol=0.0, atol=1e-12)
    assert float(jnp.linalg.norm(alone - expected)) > 1e-3


def test_exact_demonstrations_are_the_true_answer_to_what_was_played(equilibria):
    instance, _, played = equilibria
    found = jax.jit(lambda: instance.demonstrated(instance.bilevel(REGULARISATION), COMMITMENT, BELIEVED))()
    game, learner = dense(instance), np.asarray(played.learner)
    answer = oracles.soft_best_response(game.transition, game.expert_reward, learner, DISCOUNT, TEMPERATURE).policy
    occupancies = oracles.occupancy(game.transition, game.initial, learner, answer)
    truth = oracles.feature_expectation(occupancies, np.asarray(instance.expert_features), DISCOUNT)
    assert np.allclose(found, truth, rtol=0.0, atol=1e-10)


def test_the_measured_jacobian_is_taken_at_the_temperature():
    bilevel = RandomProblem.draw(3, SIZE).bilevel(REGULARISATION)
    jacobian = jnp.arange(6.0).reshape(3, 2)
    assert bilevel.problem(BELIEVED, DEMONSTRATED).demonstration_jacobian is None
    problem = bilevel.problem(BELIEVED, DEMONSTRATED, jacobian)
    assert np.allclose(problem.demonstrations_move("measured"), -jacobian / TEMPERATURE, rtol=1e-15)
    assert problem.demonstrations_move("frozen") == 0.0
