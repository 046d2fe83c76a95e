"""What a game must have."""

from typing import Any

import jax.numpy as jnp
import pytest

from gsiirl.games.base import AbstractContinuousGame
from gsiirl.types import Sides

METHODS: dict[str, Any] = {
    "action_size": property(lambda game: Sides(1, 1)),
    "reset": lambda game, key: jnp.zeros(1),
    "step": lambda game, state, actions: state,
    "observe": lambda game, state: Sides(state, state),
}


@pytest.mark.parametrize("lacking", METHODS)
def test_a_continuous_game_that_lacks_a_method_cannot_be_made(lacking: str) -> None:
    fields = {"__annotations__": {"horizon": int}, "horizon": 2}
    whole: Any = type("Whole", (AbstractContinuousGame,), fields | METHODS)
    assert repr(whole()) == "Whole(1 and 1 actions, 2 steps)"
    partial: Any = type(
        "Partial", (AbstractContinuousGame,), fields | {k: v for k, v in METHODS.items() if k != lacking}
    )
    with pytest.raises(TypeError, match=lacking):
        partial()
