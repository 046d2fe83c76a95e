"""The linear programs of Lin et al., against games that were solved by hand and by backward induction in NumPy."""

import itertools
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from problems import tiny_config, tiny_problem

from gsiirl.baselines.lin2019 import Lin2019
from gsiirl.experiments.security import run
from gsiirl.games import DensePayoff, TabularGame
from gsiirl.rewards.linear import IndicatorFeatures, TabularFeatures
from gsiirl.types import Sides, Trajectories

STATES, HORIZON, DISCOUNT = 2, 3, 0.9
JOINT = (STATES, 2, 2)
Play = tuple[np.ndarray, np.ndarray]
"""π_l and π_e, (T, S, A) each."""


def equilibrium(
    transitions: np.ndarray, rewards: tuple[np.ndarray, np.ndarray], stage: Callable[..., Play | None]
) -> Play | None:
    """Backward induction, one stage game (2x2, 2x2) at a time; None where one has no equilibrium of that kind."""
    values, found = [np.zeros(STATES), np.zeros(STATES)], []
    for _ in range(HORIZON):
        action_values = [r + DISCOUNT * transitions @ v for r, v in zip(rewards, values, strict=True)]
        stages = [stage(action_values[0][s], action_values[1][s]) for s in range(STATES)]
        if any(each is None for each in stages):
            return None
        learner, expert = (np.array([each[side] for each in stages if each is not None]) for side in (0, 1))
        values = [np.einsum("sab,sa,sb->s", q, learner, expert) for q in action_values]
        found.append((learner, expert))
    return np.array([each[0] for each in found[::-1]]), np.array([each[1] for each in found[::-1]])


def pure(learner: np.ndarray, expert: np.ndarray) -> Play | None:
    """The first pure equilibrium of a stage game."""
    for row, column in itertools.product(range(2), range(2)):
        if learner[row, column] >= learner[:, column].max() and expert[row, column] >= expert[row].max():
            return np.eye(2)[row], np.eye(2)[column]
    return None


def minimax(learner: np.ndarray, expert: np.ndarray) -> Play | None:
    """The equilibrium of a zero-sum stage game: a saddle, or both sides indifferent."""
    if (saddle := pure(learner, expert)) is not None:
        return saddle
    (a, b), (c, d) = learner
    row, column = (d - c) / (a - b - c + d), (d - b) / (a - b - c + d)
    return np.array([row, 1 - row]), np.array([column, 1 - column])


def nash_conv(transitions: np.ndarray, initial: np.ndarray, rewards: tuple[np.ndarray, ...], play: Play) -> float:
    """What the best deviations of both sides gain, by the best responses' own backward induction."""
    total = 0.0
    for side, reward in enumerate(rewards):
        best, played = np.zeros(STATES), np.zeros(STATES)
        for learner, expert in zip(*(each[::-1] for each in play), strict=True):
            mean = "sab,sb->sa" if side == 0 else "sab,sa->sb"
            hoped = reward + DISCOUNT * transitions @ best
            best = np.einsum(mean, hoped, expert if side == 0 else learner).max(-1)
            played = np.einsum("sab,sa,sb->s", reward + DISCOUNT * transitions @ played, learner, expert)
        total += float(initial @ (best - played))
    return total


def program(transitions: np.ndarray, initial: np.ndarray, own: np.ndarray, zero_sum: bool) -> Lin2019:
    game = TabularGame.from_arrays(transitions, initial=initial, horizon=HORIZON)
    features = IndicatorFeatures(shape=JOINT)
    reward = DensePayoff(jnp.asarray(own))
    return Lin2019(jax.tree.map(jnp.asarray, game), reward, Sides(features, features), DISCOUNT, 1.0, 1e4, zero_sum)


def drawn(seed: int, zero_sum: bool) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray], Play]:
    """A random game, the true rewards, and an exact equilibrium of them."""
    random = np.random.default_rng(seed)
    while True:
        transitions, initial = random.dirichlet(np.ones(STATES), JOINT), np.full(STATES, 0.5)
        expert = random.uniform(-1, 1, JOINT)
        rewards = (-expert if zero_sum else random.uniform(-1, 1, JOINT), expert)
        if (play := equilibrium(transitions, rewards, minimax if zero_sum else pure)) is not None:
            return transitions, initial, rewards, play


@pytest.mark.parametrize("zero_sum", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_what_was_shown_is_an_equilibrium_of_the_learned_rewards(seed: int, zero_sum: bool):
    transitions, initial, rewards, play = drawn(seed, zero_sum)
    assert abs(nash_conv(transitions, initial, rewards, play)) <= 1e-12
    found = program(transitions, initial, np.zeros(JOINT), zero_sum)
    policies = Sides(*map(jnp.asarray, play))
    learned = eqx.filter_jit(found.learn)(policies, jnp.full((HORIZON, STATES), 0.5))
    expert = np.asarray(learned.expert).reshape(JOINT)
    learner = -expert if zero_sum else np.asarray(learned.learner).reshape(JOINT)
    assert abs(nash_conv(transitions, initial, (learner, expert), play)) <= 1e-6
    # ... and not because they are 0: somebody loses by deviating.
    assert np.abs(expert).max() == pytest.approx(1.0)
    deviations = (1.0 - play[0], play[1]), (play[0], 1.0 - play[1])
    assert max(nash_conv(transitions, initial, (learner, expert), each) for each in deviations) >= 0.1
    # The true rewards meet every row.
    for side, reward in zip(("learner", "expert"), rewards, strict=True):
        rows = eqx.filter_jit(found.rows)(policies, DensePayoff(jnp.asarray(reward)))
        assert getattr(rows, side).max() <= 1e-12


def test_a_row_is_what_a_deviation_brings():
    # Two steps in one state and an end: the learner's first action stays, its second one ends the episode.
    stays = np.zeros((2, 2, 2, 2))
    stays[0, 0, :, 0] = stays[0, 1, :, 1] = stays[1, ..., 1] = 1.0
    game = TabularGame.from_arrays(stays, initial=[1.0, 0.0], horizon=2, terminal=[1])
    learner, expert = np.array([0.75, 0.25]), np.array([0.4, 0.6])
    policies = Sides(
        *(jnp.asarray(np.broadcast_to(each, (2, 2, 2)), dtype=float) for each in (learner, expert)),
    )
    reward = np.zeros((2, 2, 2))
    reward[0] = [[3.0, 5.0], [7.0, 2.0]]
    found = Lin2019(game, DensePayoff(jnp.asarray(reward)), Sides(*[IndicatorFeatures(shape=(2, 2, 2))] * 2), 0.5, 1, 1)
    rows = eqx.filter_jit(found.rows)(policies, found.own_reward)
    # At the last step the rows of the learner are 4.2 and 4.0 (means over the expert's play), played 4.15.
    np.testing.assert_allclose(rows.learner[1, 0], [4.2 - 4.15, 4.0 - 4.15], atol=1e-12)
    # At the first one, staying is worth half of 4.15 more; played are 4.15 + 0.75 · 2.075.
    np.testing.assert_allclose(rows.learner[0, 0], [4.2 + 2.075 - 5.70625, 4.0 - 5.70625], atol=1e-12)
    np.testing.assert_allclose(rows.expert[1, 0], [4.0 - 4.15, 4.25 - 4.15], atol=1e-12)
    np.testing.assert_allclose(rows.joint[1, 0], reward[0] - 4.15, atol=1e-12)


def test_of_a_soft_player_the_program_takes_the_reward_that_is_worth_its_violations():
    # One state, one step: the expert plays (0.3, 0.7). A deviation to its second action gains 0.3 for each 1 that it
    # likes it better, one to the first loses 0.7: means of 0.35 and 0.15.
    game = TabularGame.from_arrays(np.ones((1, 1, 2, 1)), initial=[1.0], horizon=1)
    for violation_weight, liked in ((1.3, 2.0), (1.4, 0.0)):
        found = Lin2019(
            jax.tree.map(jnp.asarray, game), DensePayoff(jnp.zeros((1, 1, 2))),
            Sides(*[IndicatorFeatures(shape=(1, 1, 2))] * 2), 1.0, 1.0, violation_weight, True,
        )  # fmt: skip
        policies = Sides(jnp.ones((1, 1, 1)), jnp.asarray([[[0.3, 0.7]]]))
        learned = np.asarray(eqx.filter_jit(found.learn)(policies, jnp.ones((1, 1))).expert)
        assert learned[1] - learned[0] == pytest.approx(liked, abs=1e-6)


@pytest.mark.parametrize(("elsewhere", "weight"), [(1.4, 1.0), (3.0, 0.0)])
def test_rewards_by_which_both_would_rather_play_something_else_must_be_worth_it(elsewhere: float, weight: float):
    """Both choose their first action, with one feature: 1 there, and `elsewhere` where both choose the second one.

    The margins gain each side half of its weight; the gap to the other equilibrium costs (`elsewhere` − 1) of it.
    """
    game = TabularGame.from_arrays(np.ones((1, 2, 2, 1)), initial=[1.0], horizon=1)
    features = TabularFeatures(table=jnp.asarray([[[[1.0], [0.0]], [[0.0], [elsewhere]]]]))
    found = Lin2019(
        jax.tree.map(jnp.asarray, game), DensePayoff(jnp.zeros((1, 2, 2))), Sides(features, features), 1.0, 1.0, 1.0
    )
    first = jnp.asarray([[[1.0, 0.0]]])
    learned = eqx.filter_jit(found.learn)(Sides(first, first), jnp.ones((1, 1)))
    np.testing.assert_allclose([learned.learner[0], learned.expert[0]], weight, atol=1e-6)


def test_what_is_estimated_is_what_was_seen():
    game = TabularGame.from_arrays(np.full((2, 2, 2, 2), 0.5), initial=[0.5, 0.5], horizon=2, terminal=None)
    features = IndicatorFeatures(shape=(2, 2, 2))
    found = Lin2019(
        jax.tree.map(jnp.asarray, game), DensePayoff(jnp.zeros((2, 2, 2))), Sides(features, features), 0.5, 1.0, 1.0
    )
    states = jnp.asarray([[0, 1], [0, 0], [1, 1], [0, 1]])
    actions = Sides(jnp.asarray([[0, 1], [0, 0], [1, 1], [1, 1]]), jnp.asarray([[1, 1], [1, 0], [1, 1], [1, 1]]))
    policies, visits = eqx.filter_jit(found.estimate)(Trajectories(states, actions, jnp.ones((4, 2), bool)))
    np.testing.assert_allclose(visits, [[0.75, 0.25], [0.125, 0.375]], atol=1e-15)
    # Each with one visit of uniform play.
    np.testing.assert_allclose(policies.learner[0, 0], [2.5 / 4, 1.5 / 4], atol=1e-15)
    np.testing.assert_allclose(policies.expert[0, 0], [0.5 / 4, 3.5 / 4], atol=1e-15)


@pytest.mark.parametrize("variant", ["general_sum", "zero_sum"])
def test_the_security_experiment_shows_it_what_ma_irl_is_shown(variant: str, monkeypatch: pytest.MonkeyPatch):
    config = tiny_config(algorithm="lin2019", variant=variant).resolved()
    problem = tiny_problem(algorithm="lin2019", variant=variant)
    edges, shape = problem.game.number_of_edges, (config.horizon, problem.game.number_of_states)
    shown, taken = [], []
    monkeypatch.setattr(run, "_demonstrations", lambda config, problem, policies, key: shown.append(policies))
    monkeypatch.setattr(Lin2019, "estimate", lambda self, seen: (self, None))
    zeros = jnp.zeros(len(problem.bilevel.expert_reward.features.names))
    commitment = zeros if variant == "zero_sum" else jnp.zeros(len(zeros) + edges)
    monkeypatch.setattr(Lin2019, "learn", lambda self, *seen: taken.append(self) or Sides(commitment, zeros + 2.0))
    learned = run._lin2019(config, problem, None).init(jax.random.key(0))  # pyright: ignore[reportArgumentType]
    true_play = run._true_play(config, problem).policies
    np.testing.assert_array_equal(shown[0].expert, true_play.expert)
    assert (taken[0].zero_sum, taken[0].bound, taken[0].violation_weight) == (variant == "zero_sum", 1.5, 1.0)
    assert learned.learner.shape == (len(zeros) + edges,)
    np.testing.assert_allclose(problem.bilevel.expert_reward.scale * learned.expert, zeros + 2.0, rtol=1e-12)
    assert true_play.learner.shape == (*shape, edges)
