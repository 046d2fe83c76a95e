import ast
import dataclasses
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from problems import tiny_problem

from gsiirl import interaction
from gsiirl.experts.tabular_expert import SimulatedExpert
from gsiirl.hypergradients import Implicit
from gsiirl.interaction import interact, live
from gsiirl.types import Sides, Trajectories

pytestmark = pytest.mark.usefixtures("optax_promotion")

ITERATIONS, TRAJECTORIES = 4, 20


@pytest.fixture(scope="module")
def problem():
    return tiny_problem(commitment="reward")


class Stranger:
    """An expert that knows nothing of the library's classes, and that JAX cannot see into."""

    def __init__(self, expert):
        self._demonstrate = eqx.filter_jit(expert.demonstrate)
        self.asked = 0

    def demonstrate(self, learner_policy, number, key) -> Trajectories:
        self.asked += number
        return jax.tree.map(lambda leaf: jnp.asarray(np.array(leaf)), self._demonstrate(learner_policy, number, key))


class Simpleton:
    """An attacker in plain Python: it always attacks the first edge that can bring something."""

    def __init__(self, problem):
        self.success, self._successors = np.asarray(problem.game.success), np.asarray(problem.game.successors)
        self.start = int(np.argmax(problem.game.initial))

    def demonstrate(self, learner_policy, number, key) -> Trajectories:
        random = np.random.default_rng(np.asarray(jax.random.key_data(key)))
        policy = np.asarray(learner_policy)
        horizon, _, edges = policy.shape
        states, blocked, attacked = (np.zeros((number, horizon), int) for _ in range(3))
        for episode in range(number):
            state = self.start
            for time in range(horizon):
                block, attack = random.choice(edges, p=policy[time, state]), int(np.argmax(self.success[state] > 0))
                states[episode, time], blocked[episode, time], attacked[episode, time] = state, block, attack
                if block != attack and random.random() < self.success[state, attack]:
                    state = int(self._successors[state, attack])
        actions = Sides(jnp.asarray(blocked), jnp.asarray(attacked))
        return Trajectories(jnp.asarray(states), actions, jnp.ones((number, horizon), bool))


@pytest.mark.slow
@pytest.mark.parametrize(("response", "interactions"), [("well_specified", 1), ("measured", 3)])
def test_one_scan_single_rounds_and_a_stranger_asked_round_by_round_teach_the_same(problem, response, interactions):
    learner = dataclasses.replace(problem.reward_learner, hypergradient=Implicit(response))
    learned = learner.fit(problem.expert, ITERATIONS, TRAJECTORIES, seed=5, progress=False)
    keys, stranger = jax.random.split(jax.random.key(5)), Stranger(problem.expert)
    *_, told = live(learner, stranger, keys[None], ITERATIONS, TRAJECTORIES, progress=False)
    start = learner.init(keys[0]), None
    scanned = jax.jit(
        lambda: interact(learner, problem.expert, start, keys[1], 0, ITERATIONS, TRAJECTORIES, lambda met: {})[0][0]
    )()
    for one, *others in zip(*map(jax.tree.leaves, (learned.state, scanned, told.states)), strict=True):
        for other in others:
            np.testing.assert_allclose(one, np.reshape(other, one.shape), rtol=0, atol=1e-9)
    assert stranger.asked == interactions * ITERATIONS * TRAJECTORIES
    # What was learned is told in reward units.
    scale = problem.reward_learner.expert_reward.scale
    np.testing.assert_allclose(learned.expert_reward, scale * learned.state.expert_parameters)
    np.testing.assert_allclose(
        learned.commitment, problem.reward_learner.dependent_reward.scale * learned.state.commitment
    )
    assert bool(learned.solution.converged)


@pytest.mark.slow
def test_an_attacker_in_plain_python_is_recognised(problem):
    simpleton = Simpleton(problem)
    learned = problem.reward_learner.fit(simpleton, 25, TRAJECTORIES, seed=0, progress=False)
    believed = np.asarray(learned.solution.policies.expert)[0, simpleton.start]
    assert int(np.argmax(believed)) == int(np.argmax(simpleton.success[simpleton.start] > 0))


def test_a_simulated_expert_is_told_the_commitment_and_the_learner_estimates_what_it_played(problem):
    told = []

    class Listening(SimulatedExpert):
        """Shows one fixed episode, whatever it is told."""

        def demonstrate_told(self, learner_reward, number, key):
            told.append(learner_reward.dense())
            nothing = jnp.zeros((number, problem.game.horizon), int)
            return Trajectories(nothing, Sides(nothing, nothing), jnp.ones_like(nothing, bool))

    learner = problem.reward_learner
    expert = Listening(problem.game, problem.expert.reward, learner.bilevel.forward_model, 0.95)
    state = learner.init(jax.random.key(3))
    proposal = learner.propose(state)
    played = expert.meet(None, proposal, TRAJECTORIES, jax.random.key(0))[1].learner_policy
    np.testing.assert_allclose(told[0], learner.bilevel.committed_reward(state.commitment).dense(), atol=1e-12)
    # Made of counts, of 20 trajectories and one visit before; what was never seen stays as proposed.
    proposed = proposal.policy
    expected = (TRAJECTORIES * jax.nn.one_hot(0, proposed.shape[-1])[None, :] + proposed[:, 0]) / (TRAJECTORIES + 1)
    np.testing.assert_allclose(played[:, 0], expected, atol=1e-12)
    np.testing.assert_allclose(played[:, 1:], proposed[:, 1:], atol=1e-12)


def test_learners_and_experts_meet_in_one_place_alone():
    source = Path(interaction.__file__).parent
    callers = {
        path.relative_to(source).as_posix()
        for path in source.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "meet"
    }
    assert callers == {"interaction.py"}
