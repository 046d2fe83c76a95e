"""The best policy for given rewards, against searches that share no code with it."""

import itertools
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from commitment_oracle import FiniteGame, Floats, extremes, learner_return
from small_games import EXPERT, HORIZON, JOINT, STATES, finite_game, tabular

from gsiirl.commitment import Commitment
from gsiirl.commitment.anew import best_answer, best_commitment
from gsiirl.games import DensePayoff


def commitment_of(game: FiniteGame) -> Commitment:
    finite = jax.tree.map(jnp.asarray, tabular(game))
    return Commitment(finite, DensePayoff(jnp.asarray(game.own[:, :, None] + game.dependent)), game.discount)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_best_commitment_is_the_one_that_another_kind_of_search_finds(seed: int):
    game = finite_game(seed, temperature=0.1)
    reward = DensePayoff(jnp.asarray(game.expert / game.temperature))
    found = jax.jit(best_commitment)(commitment_of(game), reward, jax.random.key(0))
    ceiling, _, floor = extremes(game)
    assert learner_return(game, np.asarray(found)) == pytest.approx(ceiling, abs=1e-4 * (ceiling - floor))


def fixed_return(game: FiniteGame, policy: Floats, answer: Floats) -> float:
    """What a policy earns against an expert that plays `answer` whatever happens, forward in time."""
    alive = 1.0 - np.asarray(game.terminal)
    here, total = game.initial * alive, 0.0
    for time in range(game.horizon):
        joint = here[:, None, None] * policy[time][:, :, None] * answer[time][:, None, :]
        total += game.discount**time * float((joint * (game.own[:, :, None] + game.dependent)).sum())
        here = np.einsum("sab,sabn->n", joint, game.transitions) * alive
    return total


@pytest.mark.parametrize("seed", range(4))
def test_the_best_answer_to_a_fixed_expert_is_the_best_of_all_pure_policies(seed: int):
    game = replace(finite_game(seed), learner_actions=None)
    answer = np.random.default_rng(seed).dirichlet(np.full(EXPERT, 0.3), size=(HORIZON, STATES))
    found = np.asarray(best_answer(commitment_of(game), jnp.asarray(answer)))
    # In the third state the game is over.
    choices = itertools.product(range(JOINT[1]), repeat=HORIZON * (STATES - 1))
    pure = [np.eye(JOINT[1])[np.pad(np.reshape(each, (HORIZON, STATES - 1)), ((0, 0), (0, 1)))] for each in choices]
    best = max(fixed_return(game, each, answer) for each in pure)
    assert fixed_return(game, found, answer) == pytest.approx(best, abs=1e-12)


def test_the_best_answer_keeps_to_the_actions_that_are_allowed():
    game = finite_game(3)
    answer = np.full((HORIZON, STATES, EXPERT), 1.0 / EXPERT)
    found = np.asarray(best_answer(commitment_of(game), jnp.asarray(answer)))
    assert (found[:, ~np.asarray(game.learner_actions)] == 0.0).all()
    np.testing.assert_allclose(found.sum(-1), 1.0)
