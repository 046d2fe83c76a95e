"""Cooperation, competition and classic inverse reinforcement learning are the same call with other arrays."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from commitment_oracle import Floats, extremes, learner_return
from scipy.optimize import minimize
from small_games import LEARNER_ACTIONS, expert_of, finite_game, problem_of, uniform

from gsiirl import GSIIRL
from gsiirl.equilibria.response import respond
from gsiirl.games import TabularGame
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood, Seen
from gsiirl.irl.memory import Memory
from gsiirl.irl.posterior import Inference
from gsiirl.rewards.linear import TabularFeatures

STATES, ACTIONS, HORIZON, DISCOUNT, DEVIATION = 4, 3, 5, 0.9, 3.0


class ClassicMaximumCausalEntropy:
    """Inverse reinforcement learning of a Markov decision process with finite horizon, in NumPy and SciPy.

    The reward is a table (S, A) with independent Gaussian priors; the policy is that of soft value iteration.
    """

    def __init__(self, transitions: Floats, counts: Floats) -> None:
        self.transitions, self.counts = transitions, counts

    def policy(self, reward: Floats) -> Floats:
        value, policies = np.zeros(STATES), []
        for _ in range(HORIZON):
            action_values = reward + DISCOUNT * self.transitions @ value
            value = np.log(np.exp(action_values).sum(-1))
            policies.append(np.exp(action_values - value[:, None]))
        return np.array(policies[::-1])

    def loss(self, flat: Floats) -> tuple[float, Floats]:
        """Minus the logarithm of the posterior's density, and its gradient."""
        reward = flat.reshape(STATES, ACTIONS)
        policy = self.policy(reward)
        slope, pull = np.zeros_like(reward), np.zeros(STATES)
        for time in range(HORIZON):
            visits = self.counts[time].sum(-1, keepdims=True)
            here = self.counts[time] - visits * policy[time] + pull[:, None] * policy[time]
            slope += here
            pull = DISCOUNT * np.einsum("sa,san->n", here, self.transitions)
        value = (self.counts * np.log(policy)).sum() - 0.5 * (flat**2).sum() / DEVIATION**2
        return -value, -(slope.ravel() - flat / DEVIATION**2)

    def fit(self) -> Floats:
        """The most probable reward: L-BFGS, then Newton's steps with the gradient's differences."""
        flat = minimize(self.loss, np.zeros(STATES * ACTIONS), jac=True, method="L-BFGS-B").x
        for _ in range(6):
            steps = 1e-5 * np.eye(len(flat))
            rows = [(self.loss(flat + each)[1] - self.loss(flat - each)[1]) / 2e-5 for each in steps]
            flat = flat - np.linalg.solve(np.array(rows), self.loss(flat)[1])
        assert np.abs(self.loss(flat)[1]).max() < 1e-6
        return flat


@pytest.mark.parametrize("seed", range(3))
def test_where_the_game_ignores_the_learner_the_estimate_is_that_of_classic_inverse_reinforcement_learning(
    seed: int,
) -> None:
    random = np.random.default_rng(seed)
    transitions = random.dirichlet(np.ones(STATES), size=(STATES, ACTIONS))
    start = random.dirichlet(np.ones(STATES))
    true = random.normal(size=(STATES, ACTIONS))
    # What an expert of the true reward does in ten thousand episodes, on average.
    classic = ClassicMaximumCausalEntropy(transitions, np.zeros((HORIZON, STATES, ACTIONS)))
    here, counts = 1e4 * start, []
    for policy in classic.policy(true):
        counts.append(here[:, None] * policy)
        here = np.einsum("sa,san->n", counts[-1], transitions)
    classic.counts = np.array(counts)
    expected = classic.fit()

    # The same with a learner whose two actions change nothing, and who plays at random.
    game = TabularGame.from_arrays(np.repeat(transitions[:, None], 2, axis=1), initial=start, horizon=HORIZON)
    features = np.zeros((STATES, 2, ACTIONS, STATES * ACTIONS))
    for state, action in np.ndindex(STATES, ACTIONS):
        features[state, :, action, state * ACTIONS + action] = 1.0
    model = ConditionalLikelihood(game, TabularFeatures(table=features, names=()), DISCOUNT)
    inference = jax.tree.map(jnp.asarray, Inference(model, np.asarray(DEVIATION), 1e-8))
    played = jnp.asarray(random.dirichlet(np.ones(2), size=(HORIZON, STATES)))
    seen = Seen(played, jnp.asarray(classic.counts))
    memory = Memory.empty(1, seen).remember(jax.random.key(0), seen)
    found = eqx.filter_jit(inference.fit)(inference.start(jnp.dtype(float)), memory, jax.random.key(0))
    assert bool(found.converged)
    np.testing.assert_allclose(found.mean, expected, atol=1e-5)
    answer = respond(game, played, model.features.payoff(found.mean), 1.0, DISCOUNT).policy
    np.testing.assert_allclose(answer, classic.policy(expected.reshape(STATES, ACTIONS)), atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["cooperative", "competitive"])
def test_the_learner_finds_the_best_commitment_of_cooperation_and_of_competition(kind: str) -> None:
    sign = 1.0 if kind == "cooperative" else -1.0
    for seed in range(4):
        game = finite_game(seed)
        game = replace(game, dependent=sign * game.expert, own=0.0 * game.own)
        result = GSIIRL(problem_of(game)).fit(expert_of(game), iterations=20, trajectories=100, progress=False)
        ceiling, _, floor = extremes(game, starts=32, policies=[result.policy])
        earned = learner_return(game, result.policy)
        assert ceiling - earned <= 0.01 * (ceiling - floor)
        assert earned >= learner_return(game, uniform(LEARNER_ACTIONS))
