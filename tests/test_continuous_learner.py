import dataclasses
import inspect

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest

from gsiirl.continuous_expert import ContinuousRespondingExpert
from gsiirl.continuous_learner import ContinuousGSIIRL, TwinBranches, first_states, reward_gap
from gsiirl.equilibria.pathwise import Pathwise, episodes_from, policies_of
from gsiirl.games import Crossing
from gsiirl.hypergradients import SPSA
from gsiirl.irl.maximum_likelihood import MaximumLikelihood, constant_steps, growing_steps
from gsiirl.rewards import crossing as rewards
from gsiirl.rewards.continuous import LinearTransitionReward
from gsiirl.types import Sides

pytestmark = pytest.mark.usefixtures("optax_promotion")

GAME = Crossing(horizon=4)
DISCOUNT = 0.9
PERIOD = 2
HONEST = 3
PERTURBATION = 0.05
SOLVER = Pathwise.create(GAME, discount=DISCOUNT, batch=4, hidden=4, decay_steps=100, expert_steps=1)
DEPENDENT = LinearTransitionReward(features=rewards.RobotFeatures(), scale=8.0)
EXPERT = LinearTransitionReward(features=rewards.HumanFeatures(), scale=10.0)


def make(**changes) -> ContinuousGSIIRL:
    settings = {
        "solver": SOLVER,
        "own_reward": rewards.own_reward,
        "accessed": rewards.dependent_reward,
        "dependent_reward": DEPENDENT,
        "expert_reward": EXPERT,
        "inner_loop": MaximumLikelihood(1.0, constant_steps(2), optax.adam(0.01)),
        "hypergradient": TwinBranches(PERTURBATION, PERIOD, HONEST),
        "regularisation": 1e-6,
        "trajectories": 6,
        "optimiser": optax.sgd(0.01),
        "solver_steps": 2,
        "model_response_steps": 2,
        "remembered": 3,
        "compared": 4,
        "lower_level": "played",
        "remembering": "latest",
        "exploring": True,
    }
    return ContinuousGSIIRL(**(settings | changes))


PAPER = {
    "inner_loop": MaximumLikelihood(1.0, growing_steps, optax.sgd(0.02)),
    "hypergradient": SPSA("frozen", 1.0, 1.0),
    "remembered": 1,
    "lower_level": "equilibrium",
}


def live(learner: ContinuousGSIIRL, seed: jax.Array, rounds: int):
    """States after each round with the true human."""
    expert = ContinuousRespondingExpert(SOLVER, rewards.human_reward, 2, 4)
    key = jax.random.key(seed)
    start = learner.init(key)

    def one(carry, number):
        state, habits = carry
        demonstration_key, update_key = jax.random.split(jax.random.fold_in(key, number))
        played = learner.propose(state)
        habits, seen = expert.demonstrate(habits, played, learner.trajectories, demonstration_key)
        state = learner.update(state, played, seen, update_key)
        return (state, habits), (state, seen)

    return jax.lax.scan(one, (start, expert.init(key, learner.propose(start))), jnp.arange(rounds))[1]


@pytest.fixture(scope="module")
def lived():
    learner = make()
    with jax.numpy_dtype_promotion("standard"):
        return learner, *jax.jit(jax.vmap(lambda seed: live(learner, seed, 5)))(jnp.arange(2))


def test_nothing_that_is_passed_to_the_learner_can_hold_the_experts_reward():
    assert list(inspect.signature(ContinuousGSIIRL.update).parameters) == [
        "self",
        "state",
        "learner_policy",
        "demonstrations",
        "key",
    ]
    functions = [leaf for leaf in jax.tree.leaves(make(), is_leaf=callable) if callable(leaf)]
    assert rewards.human_reward not in functions


def test_the_feature_gap_of_a_linear_reward_is_the_difference_of_discounted_features():
    state = SOLVER.init(jax.random.key(0))
    other = SOLVER.init(jax.random.key(1))
    starts = SOLVER.starts(jax.random.key(2))
    one, two = (episodes_from(GAME, policies_of(each), starts) for each in (state, other))
    found = reward_gap(EXPERT, jnp.zeros(EXPERT.number_of_parameters, jnp.float32), one, two, DISCOUNT)

    def expectation(episodes):
        features = np.asarray(jax.vmap(jax.vmap(EXPERT.features))(episodes), float)
        return (DISCOUNT ** np.arange(GAME.horizon) @ features).mean(axis=0)

    np.testing.assert_allclose(found, expectation(one) - expectation(two), atol=1e-5)
    assert float(jnp.max(jnp.abs(found))) > 1e-2
    nothing = reward_gap(EXPERT, jnp.zeros(EXPERT.number_of_parameters, jnp.float32), one, one, DISCOUNT)
    np.testing.assert_array_equal(nothing, 0.0)


def test_the_memory_holds_what_was_seen_and_the_newest_first(lived):
    _, states, seen = lived
    assert states.memory.count[:, -1].tolist() == [5, 5]
    for held, shown in zip(jax.tree.leaves(states.memory.kept.demonstrations), jax.tree.leaves(seen), strict=True):
        np.testing.assert_array_equal(held[:, -1], shown[:, :-4:-1])


def test_the_dependent_reward_is_recovered_from_the_values_read(lived):
    learner, states, seen = lived
    last = jax.tree.map(lambda leaf: leaf[0, -1], states)
    fitted = learner.fitted_dependent_reward(last)
    episodes = jax.tree.map(lambda leaf: leaf[0, -1], seen)
    modelled = jax.vmap(jax.vmap(lambda one: DEPENDENT(fitted, one)))(episodes)
    true = jax.vmap(jax.vmap(rewards.dependent_reward))(episodes)
    np.testing.assert_allclose(modelled, true, atol=5e-3)


def test_the_commitment_is_the_fit_while_honest_and_moves_along_the_perturbation_when_a_period_ends(lived):
    learner, states, _ = lived
    for seed in range(2):
        commitments = np.asarray(states.commitment[seed])
        for iteration in range(HONEST):
            at = jax.tree.map(lambda leaf, one=(seed, iteration): leaf[one], states)
            np.testing.assert_allclose(commitments[iteration], learner.fitted_dependent_reward(at), atol=1e-6)
        # The period that ends with iteration 3 is the first whose branches count.
        moved = commitments[3] - commitments[2]
        np.testing.assert_array_equal(commitments[4], commitments[3])
        assert np.abs(moved).max() > 0
        np.testing.assert_allclose(np.abs(moved), np.abs(moved).max(), rtol=1e-3)


def test_the_model_that_is_played_to_explore_acts_on_no_commitment(lived):
    learner, _, seen = lived
    state = learner.init(jax.random.key(0))
    # One twin is then at 0 as well, and all three start alike.
    opposite = -PERTURBATION * state.hypergradient.direction
    state = eqx.tree_at(lambda one: one.commitment, state, opposite)
    episodes = jax.tree.map(lambda leaf: leaf[0, 0], seen)
    after = jax.jit(learner.update)(state, learner.policy(state), episodes, jax.random.key(1))
    for leaf in jax.tree.leaves(after.hypergradient.solutions.learner.policy):
        np.testing.assert_array_equal(leaf[0], leaf[2])
    weights = jax.tree.leaves(after.hypergradient.solutions.learner.policy)[0]
    assert np.abs(weights[1] - weights[2]).max() > 0


def test_the_modelled_expert_gets_used_to_what_was_played_before_it_is_compared():
    learner = make(regularisation=0.0, inner_loop=MaximumLikelihood(1.0, constant_steps(1), optax.sgd(1e-3)))
    state = learner.init(jax.random.key(0))
    played = SOLVER.init(jax.random.key(1)).learner.policy
    modelled = learner.rewards(state.commitment, state.expert_parameters).expert
    used = SOLVER.respond(played, modelled, state.solution.expert, jax.random.key(2), 100)
    starts = first_states(jax.tree.map(lambda leaf: leaf[0], state.memory.kept.demonstrations))
    # An expert that is as the model says, once it is used to a policy that the model never met.
    seen = episodes_from(GAME, Sides(played, used.policy), starts)

    def moved(steps: int) -> float:
        one = dataclasses.replace(learner, model_response_steps=steps)
        after = jax.jit(one.update)(state, played, seen, jax.random.key(3))
        return float(jnp.linalg.norm(after.expert_parameters - state.expert_parameters))

    assert moved(100) < 0.2 * moved(0)


@pytest.mark.parametrize("exploring", [False, True])
def test_who_explores_acts_for_the_own_reward_alone_in_every_third_interaction(lived, exploring):
    _, states, _ = lived
    learner = make(exploring=exploring)
    for count in range(6):
        at = jax.tree.map(lambda leaf: leaf[0, -1], states)
        at = eqx.tree_at(lambda one: one.memory.count, at, jnp.asarray(count, jnp.int32))
        expected = learner.policy(at)
        if exploring and count % 3 == 2:
            expected = jax.tree.map(lambda leaf: leaf[2], at.hypergradient.solutions.learner.policy)
        for found, wanted in zip(jax.tree.leaves(learner.propose(at)), jax.tree.leaves(expected), strict=True):
            np.testing.assert_array_equal(found, wanted)


def test_the_model_that_acts_for_the_own_reward_alone_goes_on_when_the_twins_begin_anew(lived):
    _, states, _ = lived
    weights = np.asarray(jax.tree.leaves(states.hypergradient.solutions.learner.policy)[0][0])
    model = np.asarray(jax.tree.leaves(states.solution.learner.policy)[0][0])
    # A period ends with iterations 1 and 3, before the pair moves on.
    for iteration in (1, 3):
        np.testing.assert_array_equal(weights[iteration, 0], model[iteration - 1])
        np.testing.assert_array_equal(weights[iteration, 1], model[iteration - 1])
        assert np.abs(weights[iteration, 2] - model[iteration - 1]).max() > 0
    assert np.abs(np.diff(weights[:, 2], axis=0)).max(axis=tuple(range(1, weights.ndim - 1))).min() > 0


def test_parameters_stay_in_the_unit_ball(lived):
    _, states, _ = lived
    for parameters in (states.commitment, states.expert_parameters):
        assert float(jnp.max(jnp.linalg.norm(parameters, axis=-1))) <= 1.0 + 1e-6


@pytest.mark.slow
def test_vmapped_seeds_equal_looped_seeds(lived):
    learner, states, _ = lived
    alone, _ = jax.jit(lambda seed: live(learner, seed, 5))(jnp.asarray(1))
    for name in ("commitment", "expert_parameters"):
        np.testing.assert_allclose(getattr(states, name)[1], getattr(alone, name), atol=1e-4)


@pytest.mark.slow
def test_a_modelled_expert_that_matches_leaves_the_parameters_where_they_are():
    learner = make(regularisation=0.0, model_response_steps=0)
    state = learner.init(jax.random.key(0))
    # The memory of a new learner is the modelled expert itself, so that there is nothing to learn from it.
    starts = first_states(jax.tree.map(lambda leaf: leaf[0], state.memory.kept.demonstrations))
    seen = episodes_from(GAME, policies_of(state.solution), starts)
    still = eqx.tree_at(lambda one: one.inner_loop, learner, MaximumLikelihood(1.0, constant_steps(1), optax.sgd(1.0)))
    after = jax.jit(lambda: still.update(state, learner.propose(state), seen, jax.random.key(1)))()
    np.testing.assert_allclose(after.expert_parameters, state.expert_parameters, atol=1e-6)


@pytest.mark.slow
def test_the_papers_settings_run():
    states, _ = jax.jit(lambda: live(make(**PAPER), jnp.asarray(0), 3))()
    assert np.isfinite(np.asarray(states.commitment)).all()
    assert np.isfinite(np.asarray(states.expert_parameters)).all()
