"""The commitment oracle against finite differences, dense grids and known values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from commitment_oracle import (
    Batch,
    FiniteGame,
    Floats,
    extremes,
    learner_return,
    random_markov,
    random_one_shot,
    response,
    textbook,
)
from public_games import SELTEN_CHMURA, public_games


def masked_game(temperature: float = 0.3) -> FiniteGame:
    """A random Markov game with forbidden actions on both sides and one terminal state."""
    game = random_markov(4, 3, 3, 4, temperature, seed=5)
    return replace(
        game,
        learner_actions=np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], bool),
        expert_actions=np.array([[1, 1, 0], [1, 1, 1], [1, 1, 1], [1, 0, 1]], bool),
        terminal=np.array([0, 0, 1, 0], bool),
    )


def some_policies(game: FiniteGame, count: int, seed: int = 0) -> Floats:
    """Random interior policies over the allowed actions."""
    shape = (count, game.horizon, *game.own.shape)
    return Batch(game).tidy(np.random.default_rng(seed).gamma(np.ones(shape)))


def test_the_batch_agrees_with_the_definition() -> None:
    game = masked_game()
    policies = some_policies(game, 6)
    expected = [learner_return(game, policy) for policy in policies]
    np.testing.assert_allclose(Batch(game).values(policies), expected, atol=1e-13)


@pytest.mark.parametrize("temperature", [1.0, 0.1])
def test_the_adjoint_agrees_with_finite_differences(temperature: float) -> None:
    game = masked_game(temperature)
    batch = Batch(game)
    policies = some_policies(game, 3)
    _, slopes = batch.gradients(policies)
    step = 1e-6
    numeric = np.zeros_like(slopes)
    for index in np.ndindex(batch.shape):
        move = np.zeros(batch.shape)
        move[index] = step
        numeric[(slice(None), *index)] = (batch.values(policies + move) - batch.values(policies - move)) / (2 * step)
    np.testing.assert_allclose(slopes, numeric, atol=2e-8)
    assert np.abs(numeric).max() > 0.05


def test_responses_are_distributions_over_the_allowed_actions() -> None:
    game = masked_game()
    answer = response(game, some_policies(game, 1)[0])
    assert answer.shape == (4, 4, 3)
    np.testing.assert_allclose(answer.sum(-1), 1.0, atol=1e-12)
    assert game.expert_actions is not None
    assert (answer[:, ~game.expert_actions] == 0).all()
    assert (answer[:, game.expert_actions] > 0).all()


def test_a_response_is_the_softmax_of_its_values() -> None:
    game = random_one_shot(3, 0.4, seed=2)
    policy = some_policies(game, 1)[0]
    values = policy[0, 0] @ game.expert[0]
    expected = np.exp(values / 0.4) / np.exp(values / 0.4).sum()
    np.testing.assert_allclose(response(game, policy)[0, 0], expected, atol=1e-14)


def test_a_terminal_state_is_worth_nothing() -> None:
    game = masked_game()
    policy = some_policies(game, 1)[0]
    inside = replace(game, initial=np.array([0.0, 0.0, 1.0, 0.0]))
    assert learner_return(inside, policy) == 0.0
    # Neither its rewards nor where it leads to can be felt from outside.
    changed = replace(
        game,
        own=game.own + np.array([0, 0, 9.0, 0])[:, None],
        expert=game.expert + np.array([0, 0, 9.0, 0])[:, None, None],
        transitions=np.where(np.arange(4)[:, None, None, None] == 2, np.eye(4)[0], game.transitions),
    )
    assert learner_return(changed, policy) == pytest.approx(learner_return(game, policy), abs=1e-14)
    np.testing.assert_allclose(Batch(changed).values(policy[None]), Batch(game).values(policy[None]), atol=1e-14)


def test_another_discount_changes_the_sum_but_not_the_response() -> None:
    game = random_markov(3, 2, 2, 3, 0.3, seed=1)
    policy = some_policies(game, 1)[0]
    once = replace(game, horizon=1)
    first = np.einsum("s,sa,sb,sab->", game.initial, policy[0], response(game, policy)[0], game.dependent)
    first += np.einsum("s,sa,sa->", game.initial, policy[0], game.own)
    assert learner_return(game, policy, discount=0.0) == pytest.approx(first, abs=1e-13)
    assert learner_return(game, policy, discount=game.discount) == learner_return(game, policy)
    assert learner_return(once, policy[:1], discount=0.1) == pytest.approx(learner_return(once, policy[:1]), abs=1e-14)


@pytest.mark.parametrize(("temperature", "value"), [(0.3, 2.974), (0.1, 3.267), (0.02, 3.437)])
def test_the_textbook_game_has_its_known_values(temperature: float, value: float) -> None:
    ceiling, policy, floor = extremes(textbook(temperature))
    assert ceiling == pytest.approx(value, abs=1e-3)
    assert learner_return(textbook(temperature), policy) == pytest.approx(ceiling, abs=1e-12)
    assert floor < 2.1


@pytest.mark.parametrize("temperature", [1.0, 0.1, 0.02])
def test_the_search_matches_a_dense_grid_of_a_2x2_game(temperature: float) -> None:
    game = random_one_shot(2, temperature, seed=11)
    left = np.linspace(0, 1, 100_001)
    grid = Batch(game).values(np.stack([left, 1 - left], 1)[:, None, None, :])
    ceiling, _, floor = extremes(game)
    assert grid.max() - 1e-12 <= ceiling <= grid.max() + 1e-5
    assert grid.min() - 1e-5 <= floor <= grid.min() + 1e-12


@pytest.mark.parametrize("temperature", [0.3, 0.05])
def test_the_search_beats_a_grid_of_a_small_markov_game(temperature: float) -> None:
    game = random_markov(2, 2, 2, 2, temperature, seed=4)
    axis = np.linspace(0, 1, 17)
    points = np.stack(np.meshgrid(axis, axis, axis, axis, indexing="ij"), -1).reshape(-1, 2, 2)
    grid = Batch(game).values(np.stack([points, 1 - points], -1))
    ceiling, policy, floor = extremes(game, starts=48)
    assert grid.max() <= ceiling + 1e-9
    assert floor - 1e-9 <= grid.min()
    assert ceiling - grid.max() < 0.1 * (ceiling - floor)
    assert learner_return(game, policy) == pytest.approx(ceiling, abs=1e-12)


def test_the_ceiling_is_never_below_a_given_policy() -> None:
    game = random_markov(3, 2, 2, 2, 0.1, seed=7)
    _, best, _ = extremes(game, starts=16)
    ceiling, _, _ = extremes(game, seed=1, starts=1, policies=[best])
    assert ceiling >= learner_return(game, best)


def test_the_best_commitment_respects_the_masks() -> None:
    game = replace(masked_game(0.1), horizon=2)
    _, best, _ = extremes(game, starts=8)
    assert game.learner_actions is not None
    assert (best[:, ~game.learner_actions] == 0).all()
    np.testing.assert_allclose(best.sum(-1), 1.0, atol=1e-12)


def test_public_games_are_well_formed() -> None:
    games = public_games(0.1)
    assert len({game.name for game in games}) == len(games) == 19
    for game in games:
        np.testing.assert_allclose(game.transitions.sum(-1), 1.0, atol=1e-12)
        assert game.initial.sum() == pytest.approx(1.0)
        assert max(np.abs(game.dependent).max(), np.abs(game.expert).max()) == pytest.approx(1.0)


def test_the_selten_chmura_games_are_as_described() -> None:
    table = np.array(SELTEN_CHMURA, float)
    constant, other = table[:6], table[6:]
    assert (np.ptp(constant.sum(-1).reshape(6, 4), axis=1) == 0).all()
    shift = other - constant
    for mine, yours in zip(shift[..., 0], shift[..., 1], strict=True):
        # A constant on the right column for the row player, the same one on the upper row for the other.
        assert mine[0, 0] == mine[1, 0] == yours[1, 0] == yours[1, 1] == 0
        assert mine[0, 1] == mine[1, 1] == yours[0, 0] == yours[0, 1] > 0
    # The completely mixed equilibria of the constant-sum games: probability of the upper row and of the left column.
    known = [(0.091, 0.909), (0.182, 0.727), (0.273, 0.909), (0.364, 0.818), (0.364, 0.727), (0.455, 0.636)]
    for (mine, yours), (up, left) in zip(np.moveaxis(constant, -1, 1), known, strict=True):
        row, column = np.array([up, 1 - up]), np.array([left, 1 - left])
        assert np.ptp(mine @ column) < 0.01
        assert np.ptp(row @ yours) < 0.01
