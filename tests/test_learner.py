import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.experiments.security import SecurityConfig
from gsiirl.experiments.security_problem import SecurityProblem, build
from gsiirl.interaction import interact
from gsiirl.learner import GSIIRLState
from gsiirl.scenarios import random_network
from gsiirl.types import Interaction

pytestmark = pytest.mark.usefixtures("optax_promotion")

ITERATIONS, TRAJECTORIES, SEEDS = 4, 50, 4
CONFIG = SecurityConfig(nodes=4, edges=5, horizon=4, temperature=0.4, reward_bound=1.5, inner_steps=5, remembered=6)
CONFIG = CONFIG.resolved()


@pytest.fixture(scope="module")
def problem() -> SecurityProblem:
    return build(CONFIG, random_network(0, 4, 5))


class Runs(eqx.Module):
    """Runs of the learner with its expert, compiled once."""

    problem: SecurityProblem

    @eqx.filter_jit
    def begin(self, seed: jax.Array) -> GSIIRLState:
        return self.problem.learner.init(jax.random.key(seed))

    def _advance(self, seed: jax.Array, state: GSIIRLState, first: jax.Array) -> GSIIRLState:
        learner, expert = self.problem.learner, self.problem.expert
        key = jax.random.key(1000 + seed)
        return interact(learner, expert, state, key, first, ITERATIONS, TRAJECTORIES, lambda state, proposal: {})[0]

    @eqx.filter_jit
    def one(self, seed: jax.Array, state: GSIIRLState, first: jax.Array) -> GSIIRLState:
        """The state `ITERATIONS` rounds later."""
        return self._advance(seed, state, first)

    @eqx.filter_jit
    def many(self, seeds: jax.Array, states: GSIIRLState, first: jax.Array) -> GSIIRLState:
        """The same for all seeds at once."""
        return jax.vmap(self._advance, (0, 0, None))(seeds, states, first)


@pytest.fixture(scope="module")
def runs(problem) -> Runs:
    return Runs(problem)


def numbers_in(tree: object) -> set[float]:
    """All numbers of a tree's leaves, without sign and without 0 and 1, which stand in every game."""
    leaves = [np.asarray(leaf) for leaf in jax.tree.leaves(tree) if eqx.is_array(leaf) or isinstance(leaf, float)]
    return {abs(float(value)) for leaf in leaves for value in leaf.ravel()} - {0.0, 1.0}


def an_interaction(problem: SecurityProblem, state: GSIIRLState) -> Interaction:
    played = problem.learner.propose(state).policies.learner
    return Interaction(played, problem.expert.demonstrate(played, TRAJECTORIES, jax.random.key(5)))


def test_no_number_of_the_true_expert_reward_is_among_the_learners(problem):
    secret = numbers_in(problem.expert.reward) | numbers_in(jnp.asarray(problem.true_weights["expert_reward"]))
    assert len(secret) > 10
    assert secret & numbers_in(problem.truth)
    assert not secret & numbers_in(problem.learner)
    state = problem.learner.init(jax.random.key(0))
    # Nor is one closed over by what `update` computes.
    traced = jax.make_jaxpr(problem.learner.update)(
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
    for one, another in zip(jax.tree.leaves(problem.learner), jax.tree.leaves(other.learner), strict=True):
        np.testing.assert_array_equal(one, another)


def test_seeds_run_together_are_the_seeds_run_one_by_one(runs):
    seeds = jnp.arange(SEEDS)
    start = jax.vmap(runs.begin)(seeds)
    together = runs.many(seeds, start, jnp.asarray(0))
    for seed in range(SEEDS):
        alone = runs.one(seeds[seed], runs.begin(seeds[seed]), jnp.asarray(0))
        for one, all_of_them in zip(jax.tree.leaves(alone), jax.tree.leaves(together), strict=True):
            np.testing.assert_allclose(one, all_of_them[seed], rtol=0, atol=1e-9)


def test_the_same_seed_gives_the_same_bytes_and_another_seed_another_run(runs):
    one, again, other = (
        runs.one(jnp.asarray(seed), runs.begin(jnp.asarray(seed)), jnp.asarray(0)) for seed in (3, 3, 4)
    )
    for first, second in zip(jax.tree.leaves(one), jax.tree.leaves(again), strict=True):
        assert np.asarray(first).tobytes() == np.asarray(second).tobytes()
    assert not np.allclose(one.expert_parameters, other.expert_parameters)


def test_every_state_lies_in_the_unit_balls_and_counts_its_interactions(runs):
    seeds = jnp.arange(SEEDS)
    states = runs.many(seeds, jax.vmap(runs.begin)(seeds), jnp.asarray(0))
    for parameters in (states.commitment, states.expert_parameters):
        assert float(jnp.linalg.norm(parameters, axis=1).max()) <= 1.0 + 1e-12
    assert states.memory.count.tolist() == [ITERATIONS] * SEEDS


def test_the_learner_ends_at_least_where_marl_does_and_finds_the_rewards(problem, runs):
    seeds = jnp.arange(SEEDS)
    states = jax.vmap(runs.begin)(seeds)
    for first in range(0, 32, ITERATIONS):
        states = runs.many(seeds, states, jnp.asarray(first))

    @jax.jit
    def judged(state):
        return problem.truth.evaluate(problem.learner.propose(state).policies)["deployed_return_learner"]

    marl = float(eqx.filter_jit(problem.truth.references)()["truth_return_learner"])
    deployed = jnp.stack([judged(jax.tree.map(lambda leaf, k=k: leaf[k], states)) for k in range(SEEDS)])
    assert float(deployed.min()) >= marl - 1e-3 * abs(marl)
    # What was read of r_ld is known exactly, up to the ridge, wherever an attack was seen.
    fitted = jax.vmap(problem.learner.fitted_dependent_reward)(states) * problem.learner.bilevel.dependent_reward.scale
    losses = np.asarray(problem.true_weights["dependent_reward"])[1:4]
    np.testing.assert_allclose(fitted[:, 1:4], np.broadcast_to(losses, (SEEDS, 3)), atol=0.05)


def test_the_ascent_starts_from_the_better_of_commitment_and_fitted_reward(problem):
    learner = problem.learner
    state = learner.init(jax.random.key(0))
    true = jnp.asarray(problem.true_weights["dependent_reward"]) / learner.bilevel.dependent_reward.scale
    worse = -true
    start = eqx.filter_jit(learner._better)
    for commitment, fitted in ((worse, true), (true, worse)):
        chosen = start(commitment, fitted, state.expert_parameters)
        np.testing.assert_array_equal(chosen, true)
