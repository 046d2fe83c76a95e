"""Many ascents of f."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from small_games import finite_game, tabular

from gsiirl.commitment import search as search_module
from gsiirl.commitment.objective import Commitment
from gsiirl.commitment.search import Search, committed
from gsiirl.games import DensePayoff


def test_ascents_one_after_the_other_are_those_made_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    game = finite_game()
    finite = jax.tree.map(jnp.asarray, tabular(game))
    reward = DensePayoff(jnp.asarray(game.expert / game.temperature))
    commitment = Commitment(finite, DensePayoff(jnp.asarray(game.own[:, :, None] + game.dependent)), game.discount)
    search = Search(finite, steps=5)
    starts = search.random(4, jnp.asarray(2.0), jax.random.key(0))
    objective = committed(commitment, lambda _: reward)
    found = []
    for largest in (search_module.SMALL, 0):
        monkeypatch.setattr(search_module, "SMALL", largest)
        found.append(jax.jit(lambda starts: search.ascend(objective, starts, jnp.zeros((4, 0))))(starts))
    np.testing.assert_allclose(found[0][0], found[1][0], atol=1e-9)
    np.testing.assert_allclose(found[0][1], found[1][1], atol=1e-12)
    assert (np.asarray(found[0][1]) > -np.inf).all()
