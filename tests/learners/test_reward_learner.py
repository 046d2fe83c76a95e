import dataclasses
import inspect

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest

from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.security.problem import SecurityProblem, build
from gsiirl.experts.tabular_expert import RespondingExpert
from gsiirl.hypergradients import FiniteDifference, Implicit
from gsiirl.interaction import interact
from gsiirl.irl import reward_gradient_expectation
from gsiirl.learners.reward_learner import PROBE, RewardGSIIRL, RewardLearnerState, decaying_step
from gsiirl.scenarios import random_network
from gsiirl.types import Interaction

pytestmark = pytest.mark.usefixtures("optax_promotion")

ITERATIONS, TRAJECTORIES, SEEDS = 4, 50, 4
CONFIG = SecurityConfig(
    commitment="reward", nodes=4, edges=5, horizon=4, temperature=0.4, reward_bound=1.5, inner_steps=5, remembered=6
).resolved()


@pytest.fixture(scope="module")
def problem() -> SecurityProblem:
    return build(CONFIG, random_network(0, 4, 5))


class Runs(eqx.Module):
    """Runs of the learner with its expert, compiled once."""

    problem: SecurityProblem

    @eqx.filter_jit
    def begin(self, seed: jax.Array) -> RewardLearnerState:
        return self.problem.reward_learner.init(jax.random.key(seed))

    def _advance(self, seed: jax.Array, state: RewardLearnerState, first: jax.Array) -> RewardLearnerState:
        learner, expert = self.problem.reward_learner, self.problem.expert
        key = jax.random.key(1000 + seed)
        return interact(learner, expert, (state, None), key, first, ITERATIONS, TRAJECTORIES, lambda met: {})[0][0]

    @eqx.filter_jit
    def one(self, seed: jax.Array, state: RewardLearnerState, first: jax.Array) -> RewardLearnerState:
        """The state `ITERATIONS` rounds later."""
        return self._advance(seed, state, first)

    @eqx.filter_jit
    def many(self, seeds: jax.Array, states: RewardLearnerState, first: jax.Array) -> RewardLearnerState:
        """The same for all seeds at once."""
        return jax.vmap(self._advance, (0, 0, None))(seeds, states, first)


@pytest.fixture(scope="module")
def runs(problem) -> Runs:
    return Runs(problem)


def numbers_in(tree: object) -> set[float]:
    """All numbers of a tree's leaves, without sign and without 0 and 1, which stand in every game."""
    leaves = [np.asarray(leaf) for leaf in jax.tree.leaves(tree) if eqx.is_array(leaf) or isinstance(leaf, float)]
    return {abs(float(value)) for leaf in leaves for value in leaf.ravel()} - {0.0, 1.0}


def an_interaction(problem: SecurityProblem, state: RewardLearnerState) -> Interaction:
    assert isinstance(problem.expert, RespondingExpert)
    played = problem.reward_learner.forward(state).policies.learner
    return Interaction(played, problem.expert.demonstrate(played, TRAJECTORIES, jax.random.key(5)))


def test_no_number_of_the_true_expert_reward_is_among_the_learners(problem):
    secret = numbers_in(problem.expert.reward) | numbers_in(jnp.asarray(problem.true_weights["expert_reward"]))
    assert len(secret) > 10
    assert secret & numbers_in(problem.truth)
    assert not secret & numbers_in(problem.reward_learner)
    state = problem.reward_learner.init(jax.random.key(0))
    # Nor is one closed over by what `update` computes.
    traced = jax.make_jaxpr(problem.reward_learner.update)(
        state, jax.eval_shape(lambda: an_interaction(problem, state)), jax.random.key(1)
    )
    constants = [constant for constant in traced.consts if not jnp.issubdtype(constant.dtype, jax.dtypes.prng_key)]
    assert len(constants) > 5
    assert not secret & numbers_in(constants)


def test_the_learner_is_the_same_whatever_the_expert_wants(problem):
    network = random_network(0, 4, 5)
    other = build(
        CONFIG, dataclasses.replace(network, value=2.0 - network.value, attack_cost=0.5 * network.attack_cost)
    )
    assert numbers_in(other.expert.reward) != numbers_in(problem.expert.reward)
    for one, another in zip(
        jax.tree.leaves(problem.reward_learner), jax.tree.leaves(other.reward_learner), strict=True
    ):
        np.testing.assert_array_equal(one, another)


@pytest.mark.slow
def test_seeds_run_together_are_the_seeds_run_one_by_one(runs):
    seeds = jnp.arange(SEEDS)
    start = jax.vmap(runs.begin)(seeds)
    together = runs.many(seeds, start, jnp.asarray(0))
    for seed in range(SEEDS):
        alone = runs.one(seeds[seed], runs.begin(seeds[seed]), jnp.asarray(0))
        for one, all_of_them in zip(jax.tree.leaves(alone), jax.tree.leaves(together), strict=True):
            np.testing.assert_allclose(one, all_of_them[seed], rtol=0, atol=1e-9)


def test_the_same_seed_gives_the_same_bytes_and_another_seed_another_run(runs):
    seeds = jnp.arange(SEEDS)
    one, again = (runs.many(seeds, jax.vmap(runs.begin)(seeds), jnp.asarray(0)) for _ in range(2))
    for first, second in zip(jax.tree.leaves(one), jax.tree.leaves(again), strict=True):
        assert np.asarray(first).tobytes() == np.asarray(second).tobytes()
    assert not np.allclose(one.expert_parameters[0], one.expert_parameters[1])


def test_every_state_lies_in_the_unit_balls_and_counts_its_interactions(runs):
    seeds = jnp.arange(SEEDS)
    states = runs.many(seeds, jax.vmap(runs.begin)(seeds), jnp.asarray(0))
    for parameters in (states.commitment, states.expert_parameters):
        assert float(jnp.linalg.norm(parameters, axis=1).max()) <= 1.0 + 1e-12
    assert states.memory.count.tolist() == [ITERATIONS] * SEEDS


@pytest.mark.slow
def test_the_learner_ends_at_least_where_marl_does_and_finds_the_rewards(problem, runs):
    seeds = jnp.arange(SEEDS)
    states = jax.vmap(runs.begin)(seeds)
    for first in range(0, 32, ITERATIONS):
        states = runs.many(seeds, states, jnp.asarray(first))

    @jax.jit
    def judged(state):
        return problem.truth.evaluate(problem.reward_learner.forward(state).policies)["deployed_return_learner"]

    marl = float(eqx.filter_jit(problem.truth.references)()["truth_return_learner"])
    deployed = jnp.stack([judged(jax.tree.map(lambda leaf, k=k: leaf[k], states)) for k in range(SEEDS)])
    assert float(deployed.min()) >= marl - 1e-3 * abs(marl)
    # What was read of r_ld is known exactly, up to the ridge, wherever an attack was seen.
    fitted = (
        jax.vmap(problem.reward_learner.fitted_dependent_reward)(states) * problem.reward_learner.dependent_reward.scale
    )
    losses = np.asarray(problem.true_weights["dependent_reward"])[1:4]
    np.testing.assert_allclose(fitted[:, 1:4], np.broadcast_to(losses, (SEEDS, 3)), atol=0.05)


def test_the_ascent_starts_from_the_better_of_commitment_and_fitted_reward(problem):
    learner = problem.reward_learner
    state = learner.init(jax.random.key(0))
    true = jnp.asarray(problem.true_weights["dependent_reward"]) / learner.dependent_reward.scale
    worse = -true
    start = eqx.filter_jit(learner._better)
    for commitment, fitted in ((worse, true), (true, worse)):
        chosen = start(commitment, fitted, state.expert_parameters)
        np.testing.assert_array_equal(chosen, true)


def one_update(learner: RewardGSIIRL, state: RewardLearnerState, interaction: Interaction) -> RewardLearnerState:
    return eqx.filter_jit(learner.update)(state, interaction, jax.random.key(7))


@pytest.mark.slow
@pytest.mark.parametrize(("lower_level", "response"), [("equilibrium", "frozen"), ("played", "measured")])
def test_exact_estimators_lead_to_the_same_state(problem, lower_level, response):
    bilevel = dataclasses.replace(problem.reward_learner.bilevel, lower_level=lower_level)
    after = []
    for estimator in (Implicit(response), FiniteDifference(response)):
        learner = dataclasses.replace(problem.reward_learner, bilevel=bilevel, hypergradient=estimator)
        learner = dataclasses.replace(learner, optimiser=optax.sgd(1e-2), honest_start=False)
        state = learner.init(jax.random.key(0))
        interaction = an_interaction(problem, state)
        probes = learner.probes(state, jax.random.key(7))
        if probes is not None:
            answers = jax.vmap(lambda probe: an_interaction(problem, probe).demonstrations)(probes)
            interaction = Interaction(interaction.learner_policy, interaction.demonstrations, answers)
        after.append(one_update(learner, state, interaction))
        assert not np.allclose(after[-1].commitment, state.commitment, atol=1e-5)
    np.testing.assert_allclose(after[0].commitment, after[1].commitment, rtol=0, atol=1e-7)


def test_probes_lie_on_both_sides_of_the_commitment_and_are_asked_for_by_measured_alone(problem):
    state = problem.reward_learner.init(jax.random.key(0))
    assert problem.reward_learner.probes(state, jax.random.key(1)) is None
    measuring = dataclasses.replace(problem.reward_learner, hypergradient=Implicit("measured"))
    probes = measuring.probes(state, jax.random.key(1))
    np.testing.assert_allclose(jnp.mean(probes.commitment, axis=0), state.commitment, atol=1e-15)
    np.testing.assert_allclose(jnp.abs(probes.commitment - state.commitment[None, :]), PROBE, atol=1e-15)
    np.testing.assert_array_equal(probes.expert_parameters[1], state.expert_parameters)


@pytest.mark.slow
def test_the_measured_slope_is_the_change_of_what_the_expert_shows(problem):
    """Along its direction the Jacobian gives the difference of the demonstrations at the two probes."""
    measuring = dataclasses.replace(problem.reward_learner, hypergradient=Implicit("measured"))
    state, key = measuring.init(jax.random.key(0)), jax.random.key(1)
    probes = measuring.probes(state, key)
    answers = jax.vmap(lambda probe: an_interaction(problem, probe).demonstrations)(probes)
    seen = jax.vmap(measuring._demonstrated)(answers)
    move = probes.commitment[0] - probes.commitment[1]
    jacobian = measuring._measured(state, Interaction(measuring.forward(state).policies.learner, answers, answers), key)
    size = move.shape[0]
    np.testing.assert_allclose(jacobian @ move / size, seen[0] - seen[1], atol=1e-12)


def test_games_solved_are_counted(problem):
    for learner, evaluations, expected in (
        (problem.reward_learner, 2, 1 + 2 + 2),
        (build_paper(problem), 5, 1 + 1 + 5),
    ):
        assert int(learner._solves(jnp.asarray(0), jnp.asarray(evaluations))) == expected
    measuring = dataclasses.replace(problem.reward_learner, hypergradient=Implicit("measured"))
    # Three proposals, the two honest starts, and two solves in each evaluation with the policy as played.
    assert int(measuring._solves(jnp.asarray(0), jnp.asarray(4))) == 3 + 2 + 8


def build_paper(problem: SecurityProblem) -> RewardGSIIRL:
    return RewardGSIIRL.paper(problem.reward_learner.bilevel, iterations=ITERATIONS, smoothness=60.0)


@pytest.mark.slow
def test_the_papers_preset_takes_the_papers_steps_on_the_newest_demonstrations_alone(problem):
    paper = build_paper(problem)
    first = paper.init(jax.random.key(0))
    before = one_update(paper, first, an_interaction(problem, first))
    interaction = an_interaction(problem, before)
    state = one_update(paper, before, interaction)
    bilevel = paper.bilevel
    seen = paper._demonstrated(interaction.demonstrations)
    # Line 6, one step: μ_e under the forward model at both estimates, against the newest demonstrations.
    modelled = reward_gradient_expectation(bilevel.game, bilevel.expert_reward, paper.forward(before).policies, 0.95)
    gradient = (modelled - seen) / 0.4 + 1e-3 * before.expert_parameters
    stepped = before.expert_parameters - 0.02 * 0.4 * gradient
    np.testing.assert_allclose(state.expert_parameters, stepped / max(1.0, jnp.linalg.norm(stepped)), atol=1e-12)
    # Line 15: the second iteration's perturbation is 1/2, its step 1/(60 sqrt(4)).
    estimate, _ = paper.hypergradient.estimate(
        bilevel.problem(before.expert_parameters, seen),
        before.commitment,
        state.expert_parameters,
        before.hypergradient,
        jax.random.fold_in(jax.random.key(7), 1),
        jnp.asarray(1),
    )
    moved = before.commitment + estimate.value / 120.0
    np.testing.assert_allclose(state.commitment, moved / max(1.0, jnp.linalg.norm(moved)), atol=1e-9)


def test_the_first_step_of_the_ascent_is_in_units_of_temperature_and_halved_later(problem):
    bilevel = problem.bilevel
    steps = decaying_step(bilevel, 3.0, 20.0)
    first = 3.0 * float(bilevel.temperature) / bilevel.dependent_reward.scale
    assert [float(jnp.asarray(steps(k))) for k in (0, 20, 60)] == pytest.approx([first, first / 2, first / 4])


def test_the_defaults_are_those_of_the_experiment():
    parameters = inspect.signature(RewardGSIIRL.create).parameters
    for name in ("inner_steps", "inner_step_size", "step_size", "step_decay"):
        assert parameters[name].default == getattr(SecurityConfig(), name), name
