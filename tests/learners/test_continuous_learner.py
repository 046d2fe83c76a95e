import dataclasses
import inspect
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest

from gsiirl.equilibria.pathwise import Pathwise, policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.experts.continuous_expert import ContinuousRespondingExpert
from gsiirl.games import Crossing
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.hypergradients import SPSA, BilevelProblem, HessianVectorCG
from gsiirl.irl.feature_gap import first_states, reward_gap
from gsiirl.irl.maximum_likelihood import MaximumLikelihood, constant_steps, growing_steps
from gsiirl.learners import continuous_learner
from gsiirl.learners.continuous_learner import ContinuousLearner, GradientSteps
from gsiirl.rewards import crossing as rewards
from gsiirl.rewards.continuous import LinearTransitionReward, mean_return
from gsiirl.types import Interaction, Sides

pytestmark = pytest.mark.usefixtures("optax_promotion")

GAME = Crossing(horizon=4)
DISCOUNT = 0.9
SOLVER = Pathwise.create(GAME, discount=DISCOUNT, batch=4, hidden=4, decay_steps=100, expert_steps=1)
DEPENDENT = LinearTransitionReward(features=rewards.RobotFeatures(), scale=8.0)
EXPERT = LinearTransitionReward(features=rewards.HumanFeatures(), scale=10.0)
HUMAN = ContinuousRespondingExpert(
    GAME, rewards.human_reward, DISCOUNT, iterations=48, steps=2, first_steps=4, batch=4, hidden=4
)


def make(**changes) -> ContinuousLearner:
    settings = {
        "solver": SOLVER,
        "responder": SOLVER,
        "own_reward": rewards.own_reward,
        "accessed": rewards.dependent_reward,
        "dependent_reward": DEPENDENT,
        "expert_reward": EXPERT,
        "inner_loop": MaximumLikelihood(1.0, constant_steps(2), optax.adam(0.01)),
        "upper": None,
        "regularisation": 1e-6,
        "trajectories": 6,
        "solver_steps": 2,
        "model_response_steps": 2,
        "cloning_steps": 3,
        "remembered": 3,
        "compared": 4,
        "lower_level": "played",
    }
    return ContinuousLearner(**(settings | changes))


PAPER = {
    "inner_loop": MaximumLikelihood(1.0, growing_steps, optax.sgd(0.02)),
    "upper": GradientSteps(SPSA("frozen", 1.0, 1.0), optax.sgd(0.01)),
    "remembered": 1,
    "lower_level": "equilibrium",
}


def live(learner: ContinuousLearner, seed: jax.Array, rounds: int):
    """States after each round with the true human."""
    key = jax.random.key(seed)
    start = learner.init(key)

    def one(carry, number):
        state, habits = carry
        demonstration_key, update_key = jax.random.split(jax.random.fold_in(key, number))
        habits, met = HUMAN.meet(habits, learner.propose(state), learner.trajectories, demonstration_key)
        state = learner.update(state, met, update_key)
        return (state, habits), (state, met.demonstrations)

    return jax.lax.scan(one, (start, HUMAN.init(key, learner.propose(start).policy)), jnp.arange(rounds))[1]


@pytest.fixture(scope="module")
def lived():
    learner = make()
    with jax.numpy_dtype_promotion("standard"):
        return learner, *jax.jit(jax.vmap(lambda seed: live(learner, seed, 5)))(jnp.arange(2))


def test_nothing_that_is_passed_to_the_learner_can_hold_the_experts_reward():
    assert list(inspect.signature(ContinuousLearner.update).parameters) == [
        "self",
        "state",
        "interaction",
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
        np.testing.assert_array_equal(held[:, -1, 0], shown[:, -1])
        np.testing.assert_array_equal(held[:, 2], shown[:, jnp.asarray([2, 0, 1])])


def test_the_dependent_reward_is_recovered_from_the_values_read(lived):
    learner, states, seen = lived
    last = jax.tree.map(lambda leaf: leaf[0, -1], states)
    fitted = learner.fitted_dependent_reward(last)
    episodes = jax.tree.map(lambda leaf: leaf[0, -1], seen)
    modelled = jax.vmap(jax.vmap(lambda one: DEPENDENT(fitted, one)))(episodes)
    true = jax.vmap(jax.vmap(rewards.dependent_reward))(episodes)
    np.testing.assert_allclose(modelled, true, atol=5e-3)


def test_the_commitment_is_the_fitted_dependent_reward(lived):
    learner, states, _ = lived
    for seed, iteration in np.ndindex(2, 5):
        at = jax.tree.map(lambda leaf, one=(seed, iteration): leaf[one], states)
        np.testing.assert_allclose(at.commitment, learner.fitted_dependent_reward(at), atol=1e-6)


@pytest.mark.slow
def test_the_model_that_is_played_to_explore_acts_on_no_commitment(lived):
    learner, _, seen = lived
    episodes = jax.tree.map(lambda leaf: leaf[0, 0], seen)

    @jax.jit
    def after(weight) -> Any:
        one = dataclasses.replace(learner, own_reward=lambda seen: weight * rewards.own_reward(seen))
        state = one.init(jax.random.key(0))
        return one.update(state, Interaction(one.policy(state), episodes), jax.random.key(1))

    # A learner without a reward of its own has nothing to act for, once it commits to nothing.
    idle = after(jnp.float32(0.0))
    for before, moved in zip(
        jax.tree.leaves(learner.init(jax.random.key(0)).explorer.learner.policy),
        jax.tree.leaves(idle.explorer.learner.policy),
        strict=True,
    ):
        np.testing.assert_array_equal(before, moved)
    assert any(
        np.abs(one - other).max() > 0
        for one, other in zip(
            jax.tree.leaves(idle.solution.learner.policy), jax.tree.leaves(idle.explorer.learner.policy), strict=True
        )
    )
    busy = jax.tree.leaves(after(jnp.float32(1.0)).explorer.learner.policy)
    assert np.abs(busy[0] - jax.tree.leaves(idle.explorer.learner.policy)[0]).max() > 0


def expert_like(state, played: PolicyNetwork, reward, steps: int):
    """Episodes of an expert that has answered `played` for `steps` steps, and its policy."""
    used = SOLVER.respond(played, reward, state.solution.expert, jax.random.key(2), steps)
    starts = initial_states(GAME, jax.random.key(4), 6)
    return episodes_from(GAME, Sides(played, used.policy), starts), used.policy


@pytest.mark.slow
def test_a_response_starts_from_what_the_expert_was_seen_to_do_and_climbs_the_reward_it_is_given():
    learner = make(cloning_steps=800, compared=6, model_response_steps=60, responder=SOLVER)
    state = learner.init(jax.random.key(0))
    played = SOLVER.init(jax.random.key(1)).learner.policy
    seen, _ = expert_like(state, played, rewards.human_reward, 100)
    after = jax.jit(learner.update)(state, Interaction(played, seen), jax.random.key(3))
    newest = jax.tree.map(lambda leaf: leaf[0], after.memory.kept)
    copied = episodes_from(GAME, Sides(played, newest.clone), first_states(seen))
    np.testing.assert_allclose(copied.actions.expert, seen.actions.expert, atol=0.05)
    starts = first_states(seen)

    def worth(policy) -> float:
        return float(mean_return(rewards.human_reward, episodes_from(GAME, Sides(played, policy), starts), DISCOUNT))

    response = learner.response(newest, rewards.human_reward, jax.random.key(5))
    opposite = learner.response(newest, lambda seen: -rewards.human_reward(seen), jax.random.key(5))
    assert worth(response.policy) > worth(newest.clone) - 1e-3
    assert worth(opposite.policy) < worth(newest.clone) - 0.01


@pytest.mark.slow
def test_an_expert_that_has_learned_its_reward_shows_hardly_a_gap_at_it_and_a_wide_one_elsewhere():
    # At the truth neither the expert nor what models it has much to gain, so that the lower level stands still.
    learner = make(
        regularisation=0.0,
        cloning_steps=800,
        compared=6,
        model_response_steps=60,
        inner_loop=MaximumLikelihood(1.0, constant_steps(1), optax.sgd(1e-3)),
    )
    state = learner.init(jax.random.key(0))
    played = SOLVER.init(jax.random.key(1)).learner.policy

    update = jax.jit(learner.update)

    def moved(sign: float) -> float:
        truth = sign * state.expert_parameters
        seen, _ = expert_like(state, played, lambda seen: EXPERT(state.expert_parameters, seen), 400)
        at = eqx.tree_at(lambda one: one.iterate, state, truth)
        after = update(at, Interaction(played, seen), jax.random.key(3))
        return float(jnp.linalg.norm(after.iterate - truth))

    assert moved(1.0) < 0.3 * moved(-1.0)


@pytest.fixture(scope="module", params=[0.0, pytest.param(1e6, marks=pytest.mark.slow)])
def still(request, lived):
    """A learner whose forward model takes no steps, with what counts as far off."""
    learner = dataclasses.replace(lived[0], solver_steps=0)
    update = jax.jit(learner.update)
    with pytest.MonkeyPatch.context() as patched, jax.numpy_dtype_promotion("standard"):
        patched.setattr(continuous_learner, "FAR", request.param)
        yield learner, update, request.param


@pytest.mark.parametrize(("count", "explored"), [(3, False), (5, True)])
def test_the_expert_of_the_model_that_was_played_does_what_the_real_one_did_where_it_was_far_off(
    lived, still, count: int, explored: bool
):
    _, states, seen = lived
    learner, update, far = still
    episodes = jax.tree.map(lambda leaf: leaf[0, 0], seen)
    before = jax.tree.map(lambda leaf: leaf[0, -1], states)
    before = eqx.tree_at(lambda one: one.memory.count, before, jnp.asarray(count, jnp.int32))
    after = update(before, Interaction(learner.propose(before).policy, episodes), jax.random.key(1))
    clone = jax.tree.map(lambda leaf: leaf[0], after.memory.kept.clone)
    own, untouched = (before.explorer, before.solution) if explored else (before.solution, before.explorer)
    found, other = (after.explorer, after.solution) if explored else (after.solution, after.explorer)
    expected = own.expert.policy if far else clone
    for one, wanted in (
        *zip(jax.tree.leaves(found.expert.policy), jax.tree.leaves(expected), strict=True),
        *zip(jax.tree.leaves(other.expert.policy), jax.tree.leaves(untouched.expert.policy), strict=True),
    ):
        np.testing.assert_array_equal(one, wanted)


def test_far_off_is_ten_times_what_sampling_explains(lived, monkeypatch: pytest.MonkeyPatch):
    learner, states, seen = lived
    episodes = jax.tree.map(lambda leaf: leaf[0, 0], seen)
    state = jax.tree.map(lambda leaf: leaf[0, -1], states)
    state = eqx.tree_at(lambda one: one.memory.count, state, jnp.asarray(3, jnp.int32))
    played, own, clone = learner.propose(state).policy, state.solution.expert.policy, state.explorer.expert.policy
    modelled = episodes_from(GAME, Sides(played, own), first_states(episodes))

    def discounted(each):
        features = np.asarray(jax.vmap(jax.vmap(EXPERT.features))(each), float)
        return np.einsum("t,dtm->dm", DISCOUNT ** np.arange(GAME.horizon), features)

    gaps = discounted(modelled) - discounted(episodes)
    noise = np.sqrt(gaps.var(axis=0).sum() / len(gaps))
    apart = np.linalg.norm(gaps.mean(axis=0)) / noise
    for far, expected in ((0.95 * apart, clone), (1.05 * apart, own)):
        monkeypatch.setattr(continuous_learner, "FAR", far)
        found, _ = learner._as_seen(state, continuous_learner.Lived(played, episodes, clone))
        for one, wanted in zip(jax.tree.leaves(found.expert.policy), jax.tree.leaves(expected), strict=True):
            np.testing.assert_array_equal(one, wanted)
    assert len(gaps) == learner.trajectories


@pytest.mark.parametrize("exploring", [False, True])
def test_who_explores_acts_for_the_own_reward_alone_in_every_third_interaction(lived, exploring):
    learner, states, _ = lived
    for count in range(6):
        at = jax.tree.map(lambda leaf: leaf[0, -1], states)
        at = at if exploring else dataclasses.replace(at, explorer=None)
        at = eqx.tree_at(lambda one: one.memory.count, at, jnp.asarray(count, jnp.int32))
        expected = learner.policy(at)
        if exploring and count % 3 == 2:
            expected = at.explorer.learner.policy
        for found, wanted in zip(jax.tree.leaves(learner.propose(at).policy), jax.tree.leaves(expected), strict=True):
            np.testing.assert_array_equal(found, wanted)


def test_the_record_says_which_interactions_explored(lived):
    learner, states, _ = lived
    told = [bool(learner.report(jax.tree.map(lambda leaf, at=at: leaf[0, at], states))["exploring"]) for at in range(5)]
    assert told == [False, False, True, False, False]
    paper = make(**PAPER)
    state = paper.init(jax.random.key(0))
    state = eqx.tree_at(lambda one: one.memory.count, state, jnp.asarray(3, jnp.int32))
    assert not bool(paper.report(state)["exploring"])


def test_the_estimate_is_the_mean_of_what_the_lower_level_came_to_later_iterations_weighing_more(lived):
    learner, states, _ = lived
    wide = dataclasses.replace(learner, inner_loop=dataclasses.replace(learner.inner_loop, on_sphere=False))
    iterates = np.asarray(jax.random.uniform(jax.random.key(0), (6, states.iterate.shape[-1])), float) / 10.0
    state = jax.tree.map(lambda leaf: leaf[0, -1], states)
    for number, iterate in enumerate(iterates):
        estimate = wide._averaged(state, jnp.asarray(iterate, jnp.float32), jnp.asarray(number))
        state = dataclasses.replace(state, expert_parameters=estimate)
    # (k + 1)(k + 2)(k + 3): a cube, up to lower powers.
    weights = np.asarray([(number + 1) * (number + 2) * (number + 3) for number in range(6)], float)
    np.testing.assert_allclose(state.expert_parameters, weights @ iterates / weights.sum(), atol=1e-6)
    # And in a learner's life it lies between the one before and the newest iterate.
    before, newest, after = states.expert_parameters[:, 3], states.iterate[:, 4], states.expert_parameters[:, 4]
    np.testing.assert_allclose(after, before + 0.5 * (newest - before), atol=1e-6)


def test_the_papers_learner_believes_its_newest_iterate(lived):
    _, states, _ = lived
    paper, state = make(**PAPER), jax.tree.map(lambda leaf: leaf[0, -1], states)
    np.testing.assert_array_equal(paper._averaged(state, 0.5 * state.iterate, jnp.asarray(4)), 0.5 * state.iterate)


def test_parameters_stay_in_the_unit_ball(lived):
    _, states, _ = lived
    for parameters in (states.commitment, states.expert_parameters, states.iterate):
        assert float(jnp.max(jnp.linalg.norm(parameters, axis=-1))) <= 1.0 + 1e-6


@pytest.mark.slow
def test_vmapped_seeds_equal_looped_seeds(lived):
    learner, states, _ = lived
    alone, _ = jax.jit(lambda seed: live(learner, seed, 5))(jnp.asarray(1))
    for name in ("commitment", "expert_parameters"):
        np.testing.assert_allclose(getattr(states, name)[1], getattr(alone, name), atol=1e-4)


@pytest.mark.parametrize(("best", "reached"), [((0.3, -0.2), (0.3, -0.2)), ((3.0, 0.0), (1.0, 0.0))])
def test_the_papers_steps_climb_f_and_stay_in_the_unit_ball(
    best: tuple[float, float], reached: tuple[float, float]
) -> None:
    problem = BilevelProblem(lambda learner, expert: (-jnp.sum((learner - jnp.asarray(best)) ** 2), expert), 0.1)
    steps = GradientSteps(HessianVectorCG("well_specified"), optax.sgd(0.2))
    commitment, expert = jnp.zeros(2), jnp.zeros(1)
    remembered = steps.init(commitment, expert)
    for iteration in range(20):
        at = jnp.asarray(iteration, jnp.int32)
        commitment, remembered = steps.step(problem, commitment, expert, remembered, jax.random.key(0), at)
    np.testing.assert_allclose(commitment, reached, atol=1e-3)


def test_the_papers_learner_clones_nobody(lived):
    paper = make(**PAPER)
    state = paper.init(jax.random.key(0))
    episodes = jax.tree.map(lambda leaf: leaf[0, 0], lived[2])
    cloned = paper._cloned(state, episodes, jax.random.key(1))
    for one, other in zip(jax.tree.leaves(cloned), jax.tree.leaves(state.solution.expert.policy), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
def test_the_papers_settings_run():
    states, _ = jax.jit(lambda: live(make(**PAPER), jnp.asarray(0), 3))()
    assert np.isfinite(np.asarray(states.commitment)).all()
    assert np.isfinite(np.asarray(states.expert_parameters)).all()
