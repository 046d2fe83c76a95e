"""The stage solver against recorded pygambit solutions, against the oracle, and between its two forms of payoff."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.special import softmax

from gsiirl.equilibria.stage import newton as newton_module
from gsiirl.equilibria.stage.branch import turns_within
from gsiirl.equilibria.stage.equations import ALL
from gsiirl.equilibria.stage.solve import StageSolution, differentiable_log_policies, solve_stage
from gsiirl.equilibria.stage.unique import certified_unique
from gsiirl.games import DensePayoff, MatchingPayoff
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides
from tests import oracles

RECORDED = np.load(Path(__file__).parents[1] / "data" / "pygambit_logit.npz")
TOLERANCE = 4e-13
EXAMPLES = 12


def uniform(payoffs: Sides[AbstractPayoff]) -> Sides:
    actions = payoffs.learner.number_of_actions
    return Sides(*(jnp.full(number, -jnp.log(number)) for number in actions))


@jax.jit
@jax.vmap
def solve(payoffs: Sides[AbstractPayoff], temperature: jax.Array) -> StageSolution:
    """One stage game each, from uniform policies."""
    return solve_stage(payoffs, temperature, uniform(payoffs), TOLERANCE)


certified = jax.jit(jax.vmap(certified_unique))


# --- pygambit


def recorded(games: np.ndarray, rationality: np.ndarray) -> StageSolution:
    """Solutions [game, column] of recorded games at one lambda each."""
    columns = rationality.shape[1]
    payoffs = Sides(
        *(
            DensePayoff(jnp.asarray(np.repeat(RECORDED[name][games], columns, axis=0)))
            for name in ("learner_payoff", "expert_payoff")
        )
    )
    found = solve(payoffs, jnp.asarray(1.0 / rationality.ravel()))
    return jax.tree.map(lambda leaf: np.asarray(leaf).reshape(*rationality.shape, *leaf.shape[1:]), found)


def test_solutions_are_pygambits():
    found = recorded(np.arange(20), RECORDED["reached"])
    assert not found.branch_folds.any()
    assert found.residual.max() <= 1e-11
    np.testing.assert_allclose(np.exp(found.log_policies.learner), RECORDED["learner"], atol=1e-12)
    np.testing.assert_allclose(np.exp(found.log_policies.expert), RECORDED["expert"], atol=1e-12)


def test_solutions_beyond_a_fold_are_pygambits():
    found = recorded(RECORDED["folding_game"], RECORDED["folding_reached"])
    assert found.residual.max() <= 1e-11
    np.testing.assert_allclose(np.exp(found.log_policies.learner), RECORDED["folding_learner"], atol=1e-11)
    np.testing.assert_allclose(np.exp(found.log_policies.expert), RECORDED["folding_expert"], atol=1e-11)
    # The last game turns at 25.5 only, so at 20 it is on the way out.
    assert found.branch_folds.tolist() == [[True, True], [True, True], [False, True]]


def test_a_target_just_before_the_first_turn_is_reached_without_a_fold_and_one_just_after_it_with_one():
    turns = RECORDED["folding_turns"][:, 0]
    found = recorded(RECORDED["folding_game"], np.stack([turns * (1 - 1e-3), turns * (1 + 1e-3)], axis=1))
    assert found.residual.max() <= 1e-11
    assert found.branch_folds.tolist() == [[False, True]] * 3


# --- matching payoffs

SHAPES = [(2, 0, 0), (5, 0, 1), (6, 1, 0)]
"""Matched actions, and no-ops of the learner and of the expert; few shapes, because each is compiled."""


def matching_games(seed: int, shape: tuple[int, int, int], spread: float) -> Sides[MatchingPayoff]:
    """`EXAMPLES` games with standard normal matches; `spread` scales what an action is worth by itself."""
    matches, learner_no_op, expert_no_op = shape
    random = np.random.default_rng(seed)

    def draw(actions: int, scale: float = 1.0):
        return jnp.asarray(scale * random.normal(size=(EXAMPLES, actions)))

    learner, expert = matches + learner_no_op, matches + expert_no_op
    return Sides(
        MatchingPayoff(draw(learner, spread), draw(expert), draw(matches)),
        MatchingPayoff(draw(learner), draw(expert, spread), draw(matches)),
    )


def dense(payoffs: Sides[MatchingPayoff]) -> Sides[DensePayoff]:
    return Sides(DensePayoff(payoffs.learner.dense()), DensePayoff(payoffs.expert.dense()))


def solve_few(payoffs: Sides, temperature: np.ndarray) -> StageSolution:
    """`solve` for at most `EXAMPLES` games, as part of a batch of that size, which is compiled already."""
    batch = np.resize(np.arange(len(temperature)), EXAMPLES)
    found = solve(jax.tree.map(lambda leaf: leaf[batch], payoffs), jnp.asarray(temperature[batch]))
    return jax.tree.map(lambda leaf: leaf[: len(temperature)], found)


def assert_oracles_solutions(payoffs: Sides[MatchingPayoff], temperature: np.ndarray) -> None:
    learner, expert = np.asarray(payoffs.learner.dense()), np.asarray(payoffs.expert.dense())
    expected = [oracles.stage_logit(*matrices) for matrices in zip(learner, expert, temperature, strict=True)]
    for found in (solve_few(payoffs, temperature), solve_few(dense(payoffs), temperature)):
        assert float(found.residual.max()) <= 1e-11
        np.testing.assert_allclose(np.exp(found.log_policies.learner), [one.learner for one in expected], atol=1e-9)
        np.testing.assert_allclose(np.exp(found.log_policies.expert), [one.expert for one in expected], atol=1e-9)
        assert found.branch_folds.tolist() == [one.folded for one in expected]


seeds = st.integers(0, 2**32 - 1)
temperatures = st.floats(np.log(0.02), np.log(2.0)).map(np.exp)
spreads = st.sampled_from([1.0, 0.1])


@pytest.mark.parametrize("shape", [SHAPES[0], *(pytest.param(each, marks=pytest.mark.slow) for each in SHAPES[1:])])
@given(seed=seeds, temperature=temperatures, spread=spreads)
@settings(max_examples=2)
def test_structured_and_dense_solutions_agree_with_the_oracle(shape, seed, temperature, spread):
    payoffs = matching_games(seed, shape, spread)
    assert_oracles_solutions(payoffs, np.full(EXAMPLES, temperature))


def test_newtons_method_ends_after_its_most_steps_at_the_latest(monkeypatch):
    monkeypatch.setattr(newton_module, "NEWTON_STEPS", 3)
    payoff = DensePayoff(jnp.asarray([[1.0, 0.0], [0.0, 0.5]]))
    one, start = jnp.asarray(1.0), uniform(Sides(payoff, payoff))
    found = jax.jit(lambda: newton_module.newton(Sides(payoff, payoff), one, start, -one, one > 0, ALL))()
    assert int(found.steps) == 3


def test_a_branch_that_passes_close_by_is_not_taken_for_the_principal_one():
    """Games in which both sides gain by matching and hardly care how, drawn until a branch passed very close by."""
    random = np.random.default_rng(2)
    own, match = 0.1 * random.normal(size=(2, 400, 2)), np.abs(random.normal(size=(2, 400, 2)))
    temperature = np.exp(random.uniform(np.log(0.02), np.log(2.0), size=400))
    close = [19, 248]
    payoffs = Sides(
        MatchingPayoff(jnp.asarray(own[0, close]), jnp.zeros((2, 2)), jnp.asarray(match[0, close])),
        MatchingPayoff(jnp.zeros((2, 2)), jnp.asarray(own[1, close]), jnp.asarray(match[1, close])),
    )
    assert_oracles_solutions(payoffs, temperature[close])


def test_a_fold_shorter_than_a_step_is_seen():
    """The branch turns back at 3.34805 and forth again at 3.34750."""
    random = np.random.default_rng(7052)
    learner, expert, of_learner, of_expert = (jnp.asarray(random.normal(size=(1, n))) for n in (5, 6, 5, 5))
    payoffs = Sides(
        MatchingPayoff(0.1 * learner, jnp.zeros((1, 6)), of_learner),
        MatchingPayoff(jnp.zeros((1, 5)), 0.1 * expert, of_expert),
    )
    assert_oracles_solutions(payoffs, np.array([0.06]))
    assert solve_few(payoffs, np.array([0.06])).branch_folds.tolist() == [True]
    assert solve_few(payoffs, np.array([0.3])).branch_folds.tolist() == [False]


def test_turns_inside_a_step_are_those_of_the_cubic_with_its_slopes_and_mean():
    first, last, mean = np.random.default_rng(0).normal(size=(3, 500))
    found = jax.jit(jax.vmap(turns_within))(first, last, mean)
    # The cubic's slope first + b t + c t²: `last` at t = 1, and `mean` on average.
    c = 3 * (first + last) - 6 * mean
    t = np.linspace(0, 1, 1001)
    slopes = np.sign(first) * (first + (last - first - c) * t[:, None] + c * t[:, None] ** 2)
    least = slopes.min(axis=0)
    clear = np.abs(least) > 1e-3
    assert 0.1 < np.mean(found) < 0.5
    np.testing.assert_array_equal(found[clear], ((slopes[-1] > 0) & (least < 0))[clear])


def equilibria_from_many_starts(learner: np.ndarray, expert: np.ndarray, temperature: float, seed: int) -> np.ndarray:
    """The learner's halves of the equilibria that Newton's method finds on p − softmax(A softmax(Bᵀp/τ)/τ) = 0."""
    random = np.random.default_rng(seed)
    actions = learner.shape[0]
    p = np.concatenate([random.dirichlet(np.full(actions, 0.2), size=300), np.eye(actions)])

    def slopes(policies: np.ndarray, payoff: np.ndarray) -> np.ndarray:
        """(diag π − π πᵀ) A/τ for each of several policies."""
        covariances = policies[:, :, None] * (np.eye(policies.shape[1]) - policies[:, None, :])
        return covariances @ payoff / temperature

    def missed(p: np.ndarray) -> np.ndarray:
        return p - softmax(softmax(p @ expert / temperature, axis=-1) @ learner.T / temperature, axis=-1)

    lengths = 0.5 ** np.arange(12)[:, None, None]
    for _ in range(60):
        q = softmax(p @ expert / temperature, axis=1)
        answer = softmax(q @ learner.T / temperature, axis=1)
        jacobian = np.eye(actions) - slopes(answer, learner) @ slopes(q, expert.T)
        step = np.linalg.solve(jacobian, missed(p)[:, :, None])[:, :, 0]
        tried = np.clip(p - lengths * step, 1e-300, 1.0)
        tried /= tried.sum(axis=2, keepdims=True)
        best = np.abs(missed(tried)).max(axis=2).argmin(axis=0)
        p = tried[best, np.arange(len(p))]
    return p[np.abs(missed(p)).max(axis=1) < 1e-10]


@pytest.mark.parametrize("shape", SHAPES)
@given(seed=seeds, temperature=temperatures, spread=spreads)
@settings(max_examples=6)
def test_where_uniqueness_is_certified_no_second_equilibrium_is_found(shape, seed, temperature, spread):
    payoffs = matching_games(seed, shape, spread)
    sure = np.asarray(certified(payoffs, jnp.full(EXAMPLES, 1.0 / temperature)))
    assume(sure.any())
    number = int(np.argmax(sure))
    matrices = np.asarray(payoffs.learner.dense()[number]), np.asarray(payoffs.expert.dense()[number])
    found = equilibria_from_many_starts(*matrices, temperature, seed)
    assert len(found) > 0
    assert np.ptp(found, axis=0).max() <= 1e-6


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_where_a_match_helps_one_side_and_hurts_the_other_one_equilibrium_is_certified_at_every_temperature(sign):
    random = np.random.default_rng(0)
    own, match = random.normal(size=(2, 100, 4)), sign * random.uniform(0.1, 2.0, size=(2, 100, 3))
    nothing = jnp.zeros((100, 4))
    payoffs = Sides(
        MatchingPayoff(jnp.asarray(own[0]), nothing, jnp.asarray(match[0])),
        MatchingPayoff(nothing, jnp.asarray(own[1]), jnp.asarray(-match[1])),
    )
    for inverse in (0.1, 1.0, 10.0, 100.0):
        assert np.all(certified(payoffs, jnp.full(100, inverse)))


def test_newton_ends_where_no_step_helps_any_more():
    payoff = MatchingPayoff(jnp.asarray([0.1, 0.0]), jnp.zeros(2), jnp.ones(2))
    payoffs = Sides(payoff, payoff)
    # No residual is below -1, so that steps get shorter to the end.
    found = jax.jit(newton_module.newton)(payoffs, jnp.asarray(2.0), uniform(payoffs), -1.0, jnp.asarray(True), ALL)
    assert 5e-7 < float(found.length) <= 1e-6
    assert int(found.steps) < newton_module.NEWTON_STEPS


def test_a_coordination_game_with_three_equilibria_is_not_certified():
    payoff = MatchingPayoff(jnp.asarray([[0.1, 0.0]]), jnp.zeros((1, 2)), jnp.ones((1, 2)))
    [matrix] = np.asarray(payoff.dense())
    found = equilibria_from_many_starts(matrix, matrix, 0.1, 0)
    assert len(np.unique(found.round(6), axis=0)) == 3
    assert not certified(Sides(payoff, payoff), jnp.asarray([10.0])).item()


def test_no_game_of_two_actions_with_several_equilibria_is_certified():
    random = np.random.default_rng(0)
    own, match = 0.1 * random.normal(size=(2, 2000, 2)), random.normal(size=(2, 2000, 2))
    nothing = jnp.zeros((2000, 2))
    payoffs = Sides(
        MatchingPayoff(jnp.asarray(own[0]), nothing, jnp.asarray(match[0])),
        MatchingPayoff(nothing, jnp.asarray(own[1]), jnp.asarray(match[1])),
    )
    rationality = np.exp(random.uniform(0.0, 3.0, size=(2000, 1)))
    sure = np.asarray(certified(payoffs, jnp.asarray(rationality[:, 0])))

    def response(side: int, other: np.ndarray) -> np.ndarray:
        """Probability of the first action, against that of the other side."""
        difference = np.diff(own[side])[:, ::-1] - match[side, :, :1] * other + match[side, :, 1:] * (1.0 - other)
        return 1.0 / (1.0 + np.exp(rationality * difference))

    # Equilibria are where the response to the response crosses the diagonal.
    grid = np.linspace(0.0, 1.0, 2001)[None, :]
    crossings = np.sum(np.diff(np.sign(response(0, response(1, grid)) - grid), axis=1) != 0, axis=1)
    assert (crossings > 1).sum() >= 20
    assert sure.sum() >= 100
    assert not np.any(sure & (crossings > 1))


def test_derivatives_are_those_of_the_solution():
    payoffs = matching_games(5, (5, 0, 1), 1.0)
    one, direction = (jax.tree.map(lambda leaf, k=k: leaf[k], payoffs) for k in (0, 1))
    temperature = np.full(3, 0.4)

    def along(step: float | jax.Array) -> Sides[MatchingPayoff]:
        return jax.tree.map(lambda leaf, by: leaf + step * by, one, direction)

    steps = [along(step) for step in (-1e-5, 0.0, 1e-5)]
    found = solve_few(jax.tree.map(lambda *leaves: jnp.stack(leaves), *steps), temperature).log_policies
    before, here, after = (jax.tree.map(lambda leaf, k=k: leaf[k], found) for k in range(3))
    at = jnp.asarray(0.4)
    slope = jax.jacfwd(lambda step: differentiable_log_policies(along(step), at, here))(jnp.asarray(0.0))
    difference = jax.tree.map(lambda a, b: (a - b) / 2e-5, after, before)
    np.testing.assert_allclose(slope.learner, difference.learner, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(slope.expert, difference.expert, rtol=1e-6, atol=1e-8)
