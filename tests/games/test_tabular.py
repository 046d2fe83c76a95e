"""A game of arrays means what its arrays say."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.errors import InputError
from gsiirl.games import DensePayoff, TabularGame
from gsiirl.games.base import uniform_policy
from gsiirl.games.rollout import rollout
from gsiirl.types import Sides

STATES, LEARNER, EXPERT = 4, 2, 3
START = np.array([0.1, 0.2, 0.3, 0.4])


def dense(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).dirichlet(np.ones(STATES), size=(STATES, LEARNER, EXPERT))


def policies(seed: int = 1) -> Sides:
    random = np.random.default_rng(seed)
    return Sides(*(jnp.asarray(random.dirichlet(np.ones(actions), size=STATES)) for actions in (LEARNER, EXPERT)))


def test_the_next_state_is_drawn_as_the_array_says() -> None:
    table = dense()
    game = TabularGame.from_arrays(table, initial=START, horizon=2)
    values = np.array([1.0, -2.0, 0.5, 3.0])
    np.testing.assert_allclose(game.continuation(jnp.asarray(values)).dense(), table @ values, atol=1e-14)
    played = policies()
    expected = np.einsum("s,sa,sb,sabn->n", START, played.learner, played.expert, table)
    np.testing.assert_allclose(game.advance(jnp.asarray(START), played), expected, atol=1e-14)


def test_successors_and_probabilities_are_another_way_to_say_the_same() -> None:
    table = dense()
    order = np.random.default_rng(2).permutation(STATES)
    shape = (STATES, LEARNER, EXPERT, STATES)
    pair = np.broadcast_to(order, shape), table[..., order]
    one = TabularGame.from_arrays(table, initial=START, horizon=2)
    other = TabularGame.from_arrays(pair, initial=START, horizon=2)
    values, played = jnp.arange(4.0), policies()
    np.testing.assert_allclose(one.continuation(values).dense(), other.continuation(values).dense(), atol=1e-14)
    np.testing.assert_allclose(
        one.advance(jnp.asarray(START), played), other.advance(jnp.asarray(START), played), atol=1e-14
    )


def test_of_a_large_game_only_what_can_follow_is_kept() -> None:
    states = 30
    table = np.zeros((states, 2, 2, states))
    for state in range(states):
        table[state, ..., (state + 1) % states] = 0.75
        table[state, ..., (7 * state) % states] += 0.25
    game = TabularGame.from_arrays(table, initial=np.full(states, 1 / states), horizon=3)
    assert game.successors.shape == game.probabilities.shape == (states, 2, 2, 2)
    values = np.random.default_rng(0).normal(size=states)
    np.testing.assert_allclose(game.continuation(jnp.asarray(values)).dense(), table @ values, atol=1e-14)


def test_games_of_one_shape_have_arrays_of_one_shape() -> None:
    sparse = np.zeros((STATES, LEARNER, EXPERT, STATES))
    sparse[..., 0] = 1.0
    games = [TabularGame.from_arrays(table, initial=START, horizon=2) for table in (dense(), sparse)]
    assert jax.tree.structure(games[0]) == jax.tree.structure(games[1])
    assert [leaf.shape for leaf in jax.tree.leaves(games[0])] == [leaf.shape for leaf in jax.tree.leaves(games[1])]


def test_the_size_of_the_policies_counts_both_sides() -> None:
    game = TabularGame.from_arrays(dense(), initial=START, horizon=2)
    assert game.policy_size == sum(np.zeros((2, STATES, actions)).size for actions in (LEARNER, EXPERT))


def test_rounding_in_probabilities_is_mended() -> None:
    game = TabularGame.from_arrays(dense().astype(np.float32), initial=START.astype(np.float32), horizon=2)
    np.testing.assert_allclose(np.sum(game.probabilities, axis=-1), 1.0, atol=1e-15)
    np.testing.assert_allclose(np.sum(game.initial), 1.0, atol=1e-15)


def test_arrays_are_kept_in_double_precision_and_are_copies() -> None:
    table, mask = dense(), np.array([[True, False]] + [[True, True]] * 3)
    with jax.enable_x64(False):
        game = TabularGame.from_arrays(table, initial=START, horizon=2, learner_actions=mask)
    assert isinstance(game.probabilities, np.ndarray)
    assert game.probabilities.dtype == game.initial.dtype == np.float64
    before = game.probabilities.copy()
    table[:], mask[:] = 0.0, False
    np.testing.assert_array_equal(game.probabilities, before)
    assert game.learner_actions is not None
    assert game.learner_actions[1:].all()


def test_a_mask_that_forbids_nothing_is_none() -> None:
    game = TabularGame.from_arrays(
        dense(),
        initial=START,
        horizon=2,
        learner_actions=np.ones((STATES, LEARNER), bool),
        expert_actions=np.ones((STATES, EXPERT), bool),
        terminal=np.zeros(STATES, bool),
    )
    assert (game.learner_actions, game.expert_actions, game.terminal) == (None, None, None)
    assert game.allowed == Sides(None, None)


def test_a_terminal_state_is_named_by_a_list_or_by_booleans_and_never_left() -> None:
    table = dense()
    table[2] = 0.0  # where it would lead to need not be said
    listed = TabularGame.from_arrays(table, initial=START, horizon=2, terminal=[2])
    flagged = TabularGame.from_arrays(table, initial=START, horizon=2, terminal=np.arange(STATES) == 2)
    for game in (listed, flagged):
        np.testing.assert_array_equal(game.terminal, [False, False, True, False])
        inside = game.advance(jnp.array([0.0, 0.0, 1.0, 0.0]), policies())
        np.testing.assert_array_equal(inside, [0.0, 0.0, 1.0, 0.0])
        np.testing.assert_array_equal(game.alive(jnp.ones(STATES)), [1.0, 1.0, 0.0, 1.0])
    assert TabularGame.from_arrays(dense(), initial=START, horizon=2, terminal=[]).terminal is None


def test_what_a_mask_says_of_a_terminal_state_does_not_matter() -> None:
    mask = np.ones((STATES, LEARNER), bool)
    mask[2] = False
    game = TabularGame.from_arrays(dense(), initial=START, horizon=2, learner_actions=mask, terminal=[2])
    assert game.learner_actions is None


def test_episodes_follow_the_dynamics_the_masks_and_the_end() -> None:
    number = 20_000
    mask = np.array([[True, False], [True, True], [True, True], [True, True]])
    table = dense()
    game = TabularGame.from_arrays(table, initial=START, horizon=3, learner_actions=mask, terminal=[2])
    played = Sides(uniform_policy(game), jnp.full((3, STATES, EXPERT), 1 / EXPERT))
    keys = jax.random.split(jax.random.key(0), number)
    seen = jax.jit(jax.vmap(lambda key: rollout(key, game, played)))(keys)
    states, kept = np.asarray(seen.states), np.asarray(seen.mask)
    np.testing.assert_array_equal(kept, states != 2)
    assert not np.asarray(seen.actions.learner)[kept & (states == 0)].any()
    distribution = jnp.asarray(START)
    for time in range(3):
        # Five standard deviations of a frequency are at most 2.5 / sqrt(number).
        frequencies = np.bincount(states[:, time], minlength=STATES) / number
        np.testing.assert_allclose(frequencies, distribution, atol=2.5 / np.sqrt(number))
        at_time = jax.tree.map(lambda policy, time=time: policy[time], played)
        distribution = game.advance(distribution, at_time)


@pytest.mark.parametrize("side", ["learner", "expert"])
def test_a_uniform_policy_is_uniform_over_what_is_allowed(side: str) -> None:
    mask = np.array([[True, False], [True, True], [False, True], [True, True]])
    game = TabularGame.from_arrays(
        dense()[:, :, :2],
        initial=START,
        horizon=2,
        **{f"{side}_actions": mask},  # pyright: ignore[reportArgumentType]
    )
    uniform = np.asarray(uniform_policy(game))
    expected = mask / mask.sum(-1, keepdims=True) if side == "learner" else np.full((STATES, 2), 0.5)
    np.testing.assert_allclose(uniform, np.broadcast_to(expected, (2, STATES, 2)), atol=1e-15)


def test_rewards_of_a_payoff_are_those_of_its_array() -> None:
    table = np.random.default_rng(3).normal(size=(STATES, LEARNER, EXPERT))
    played = policies()
    expected = np.einsum("sa,sb,sab->s", played.learner, played.expert, table)
    np.testing.assert_allclose(DensePayoff(table).expected(played.learner, played.expert), expected, atol=1e-14)


@pytest.mark.parametrize("index", [-1, 2])
def test_a_successor_that_is_no_state_is_refused_with_the_numbers_that_are(index: int) -> None:
    with pytest.raises(InputError, match=r"give whole numbers from 0 to 1$"):
        TabularGame.from_arrays((np.full((2, 2, 2, 1), index), np.ones((2, 2, 2, 1))), initial=[1.0, 0.0], horizon=1)


@pytest.mark.parametrize("side", ["learner_actions", "expert_actions"])
def test_a_state_in_which_a_side_may_do_nothing_is_refused(side: str) -> None:
    mask = np.array([[True, True], [False, False]])
    with pytest.raises(InputError, match=side):
        TabularGame.from_arrays(np.full((2, 2, 2, 2), 0.5), initial=[1.0, 0.0], horizon=1, **{side: mask})


@pytest.mark.parametrize(
    ("terminal", "said"), [([0, 0, 1], "names a state twice"), ([STATES], f"holds {STATES}, which is no state")]
)
def test_zeros_and_ones_are_not_taken_for_states(terminal: list[int], said: str) -> None:
    with pytest.raises(InputError, match=f"terminal: {said}"):
        TabularGame.from_arrays(dense(), initial=START, horizon=2, terminal=terminal)
