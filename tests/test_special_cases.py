"""Cooperation, competition and classic inverse reinforcement learning are the same call with other arrays."""

import itertools
import math
from dataclasses import replace
from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from commitment_oracle import FiniteGame, Floats, extremes, learner_return, one_shot, random_markov
from scipy.optimize import minimize
from small_games import LEARNER_ACTIONS, expert_of, finite_game, problem_of, uniform
from special_case_oracles import CausalEntropy, soft_minimax, stage

from gsiirl import GSIIRL, Problem, RespondingExpert
from gsiirl.equilibria.response import respond
from gsiirl.experiments.game.examples import EXAMPLES
from gsiirl.games import DensePayoff, TabularGame
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood, Seen
from gsiirl.irl.inference import MatchingLevel, MatchingState
from gsiirl.irl.memory import Memory, Played
from gsiirl.irl.posterior import Inference
from gsiirl.rewards.linear import Linear, TabularFeatures
from gsiirl.types import Sides

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


def test_the_planner_is_that_of_a_published_library() -> None:
    # imitation 1.0.1, recorded by scripts/record_imitation.py: no discount, temperature 1, a reward of the state alone.
    recorded = np.load(Path(__file__).parent / "data" / "imitation_mce.npz")
    horizon, states = recorded["values"].shape
    actions, random = recorded["policy"].shape[2], np.random.default_rng(0)
    transitions = random.dirichlet(np.full(states, 0.05), (states, actions))
    start, reward = random.dirichlet(np.ones(states)), random.normal(size=states)
    game = TabularGame.from_arrays(transitions[:, None], initial=start, horizon=horizon)
    payoff = DensePayoff(jnp.asarray(np.broadcast_to(reward[:, None, None], (states, 1, actions))))
    alone = jnp.ones((horizon, states, 1))
    answer = jax.jit(respond)(game, alone, payoff, 1.0, 1.0)
    np.testing.assert_allclose(answer.values, recorded["values"], atol=1e-12)
    np.testing.assert_allclose(answer.policy[:2], recorded["policy"], atol=1e-12)
    at, visits = jnp.asarray(start), 0.0
    for policy in answer.policy:
        visits = visits + at
        at = game.advance(at, Sides(alone[0], policy))
    np.testing.assert_allclose(visits, recorded["occupancy"], atol=1e-12)


def test_estimate_and_errors_are_those_of_a_published_library_where_the_horizon_is_long_and_the_prior_flat() -> None:
    # econirl 0.1.1, recorded by scripts/record_econirl.py: discount 0.3, no end, no prior. Ours plans to step 100.
    recorded = np.load(Path(__file__).parent / "data" / "econirl_nfxp.npz")
    counts = jnp.asarray(recorded["counts"])
    transitions = recorded["transitions"]
    start = np.full(len(transitions), 1 / len(transitions))
    game = TabularGame.from_arrays(transitions[:, None], initial=start, horizon=len(counts))
    model = ConditionalLikelihood(game, TabularFeatures(table=recorded["features"][:, None], names=()), 0.3)
    inference = jax.tree.map(jnp.asarray, Inference(model, np.asarray(1e4), 1e-8))
    seen = Seen(jnp.ones((*counts.shape[:2], 1)), counts)
    memory = Memory.empty(1, seen).remember(jax.random.key(0), seen)
    found = eqx.filter_jit(inference.fit)(inference.start(jnp.dtype(float)), memory, jax.random.key(0))
    assert bool(found.converged)
    errors = np.sqrt(np.diag(np.linalg.inv(np.asarray(found.precision))))
    np.testing.assert_allclose(found.mean, recorded["estimate"], rtol=2e-3)
    np.testing.assert_allclose(errors, recorded["errors"], rtol=2e-3)


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


@pytest.mark.parametrize("seed", range(2))
def test_matching_exact_occupancies_comes_to_the_reward_and_policy_of_maximum_causal_entropy(seed: int) -> None:
    states, actions, horizon, scale, regularisation = 2, 2, 3, 6.0, 0.02
    random = np.random.default_rng(seed)
    transitions = random.dirichlet(np.ones(states), size=(states, actions))
    start = random.dirichlet(np.ones(states))
    classic = CausalEntropy(transitions, start, horizon, DISCOUNT)
    seen = classic.occupancies(classic.solve(random.normal(size=(states, actions)))[1])
    # The package's λ is on θ = r/scale.
    expected = classic.fit(seen, regularisation / scale**2)
    game = jax.tree.map(jnp.asarray, TabularGame.from_arrays(transitions[:, None], initial=start, horizon=horizon))
    features = TabularFeatures(table=jnp.eye(states * actions).reshape(states, 1, actions, -1), names=())
    reward = Linear(features, scale)
    level = MatchingLevel(ConditionalLikelihood(game, features, DISCOUNT), reward, regularisation, 400, 1e-3)
    finer = replace(level, step_size=1e-5)
    played = jnp.ones((horizon, states, 1))

    def matched(level: MatchingLevel, state: MatchingState) -> MatchingState:
        again = Played(played, jnp.asarray(scale * seen.ravel()))
        return jax.lax.fori_loop(0, 25, lambda k, now: level.match(now, again, jax.random.key(0)), state)

    with jax.numpy_dtype_promotion("standard"):  # Adam takes powers of its step count
        found = level.estimate(jax.jit(lambda state: matched(finer, matched(level, state)))(level.init(1)))
    np.testing.assert_allclose(found, expected.ravel(), atol=1e-6)
    answer = respond(game, played, features.payoff(found), 1.0, DISCOUNT).policy
    np.testing.assert_allclose(answer, classic.solve(expected)[1], atol=1e-6)


def test_the_oracle_of_a_stage_finds_the_least_soft_value_of_a_grid() -> None:
    for seed in range(5):
        payoff = np.random.default_rng(seed).uniform(-1, 1, (2, 3))
        value, _ = stage(payoff, 0.2)
        mixtures = np.linspace(0, 1, 20001)[:, None] * payoff[0] + np.linspace(1, 0, 20001)[:, None] * payoff[1]
        least = 0.2 * np.log(np.exp(mixtures / 0.2).sum(-1)).min()
        assert least - 1e-7 <= value <= least + 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_the_best_commitment_of_a_competitive_game_lies_between_the_bounds(seed: int) -> None:
    game = random_markov(2, 2, 3, 2, 0.3, seed)
    game = replace(game, dependent=-game.expert, own=0.0 * game.own)
    value, safe = soft_minimax(game)
    ceiling, _, _ = extremes(game, starts=16, policies=[safe])
    most = game.temperature * math.log(3) * (1 + game.discount)
    assert -value - 1e-9 <= learner_return(game, safe) <= ceiling <= most - value + 1e-9


@pytest.mark.slow
def test_in_matching_pennies_the_learner_plays_both_sides_alike_and_loses_nothing() -> None:
    """Where p is the probability of heads the learner earns −d tanh(d/τ), d = 2p − 1: the upper bound at p = 1/2."""
    temperature = 0.2
    pennies = np.array([[1.0, -1.0], [-1.0, 1.0]])
    game = one_shot("matching pennies", -pennies, pennies, temperature)
    value, safe = soft_minimax(game)
    assert value == pytest.approx(temperature * math.log(2))
    np.testing.assert_allclose(safe[0, 0], 0.5, atol=1e-6)
    result = GSIIRL(problem_of(game)).fit(expert_of(game), iterations=20, trajectories=100, progress=False)
    assert learner_return(game, result.policy) >= temperature * math.log(2) - value - 2e-3
    np.testing.assert_allclose(result.policy[0, 0], 0.5, atol=0.02)


def pursuit() -> FiniteGame:
    """A pursuer (the learner) and an evader on a field of 2 x 3 cells; who stands on the other's cell has caught it."""
    cells = list(itertools.product(range(2), range(3)))
    moves = ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1))

    def moved(cell: int, action: int) -> int:
        goal = (cells[cell][0] + moves[action][0], cells[cell][1] + moves[action][1])
        return cells.index(goal) if goal in cells else cell

    count = len(cells)
    follows, caught = np.zeros((count**2, 5, 5, count**2)), np.zeros((count**2, 5, 5))
    for (hunter, prey), *both in itertools.product(itertools.product(range(count), repeat=2), range(5), range(5)):
        after = moved(hunter, both[0]), moved(prey, both[1])
        follows[(hunter * count + prey, *both, after[0] * count + after[1])] = 1.0
        caught[(hunter * count + prey, *both)] = after[0] == after[1]
    initial = np.zeros(count**2)
    initial[0 * count + 5] = 1.0
    return FiniteGame("pursuit", follows, initial, 5, np.zeros((count**2, 5)), caught, -caught, 0.95, 0.2)


def soccer() -> FiniteGame:
    arrays = EXAMPLES["competitive"]()
    reward, terminal = arrays["expert_reward"], arrays["terminal"]
    return FiniteGame(
        "soccer", arrays["transitions"], arrays["initial"], arrays["horizon"], np.zeros(reward.shape[:2]), -reward,
        reward, 0.95, arrays["temperature"], terminal=terminal,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("game", [pursuit(), soccer()], ids=["pursuit", "soccer"])
def test_pursuit_and_soccer_are_played_within_the_bounds_and_with_little_regret(game: FiniteGame) -> None:
    value, safe = soft_minimax(game)
    features = game.expert[..., None]
    result = GSIIRL(problem_of(game, expert_features=features)).fit(
        expert_of(game), iterations=15, trajectories=100, progress=False
    )
    earned, evaluation = learner_return(game, result.policy), result.evaluate(game.expert)
    most = game.temperature * math.log(5) * sum(game.discount**time for time in range(game.horizon))
    best = max(evaluation.ceiling, learner_return(game, safe))
    assert -value - 1e-6 <= best <= most - value
    assert best - earned <= 0.01 * (best - evaluation.floor)
    assert earned >= -value


@pytest.mark.slow
def test_in_the_maze_the_learner_holds_the_door_to_what_the_expert_likes_best() -> None:
    arrays = EXAMPLES["cooperative"]()
    game = TabularGame.from_arrays(arrays["transitions"], initial=arrays["initial"], horizon=arrays["horizon"])
    reward, temperature = arrays["expert_reward"], arrays["temperature"]
    problem = Problem(game, dependent_value=reward, temperature=temperature, expert_features=arrays["expert_features"])
    expert = RespondingExpert(game, reward, temperature=temperature, discount=0.95)
    result = GSIIRL(problem).fit(expert, iterations=15, trajectories=100, progress=False)
    earned = result.evaluate(reward)
    assert earned.ceiling - earned.deployed <= 0.02 * (earned.ceiling - earned.random)
    # It begins in the middle row; the upper door leads to the cell that is worth most.
    assert result.policy[2, 1, 0] >= 0.99
