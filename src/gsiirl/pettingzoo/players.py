"""Who can play one side: somebody who maps what it observes to an action."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gsiirl.adapters.numpy_policy import NumpyPolicy
from gsiirl.errors import InputError

Player = Callable[[np.ndarray, np.random.Generator], Any]
"""`player(observation, random)` is the action; what it leaves to chance, it draws from `random`."""


@dataclass(frozen=True)
class TablePlayer:
    """A policy π(a|s, t) of the attack graph."""

    table: np.ndarray
    """(T, S, A)."""
    compromised: np.ndarray
    """1 for each node that is compromised in a state, else 0 (S, N)."""

    def __call__(self, observation: np.ndarray, random: np.random.Generator) -> int:
        """The action, drawn from π.

        Raises:
            InputError: the observation is of no state of the game, or of the end of an episode.
        """
        time, state = round(float(observation[-1]) * len(self.table)), self._states.get(_code(observation[:-1]))
        if state is None or not 0 <= time < len(self.table):
            mend = "give one of the game that the policy was learned in, before the end of an episode"
            raise InputError("observation", f"{observation} is none that the policy knows", mend)
        chances = np.cumsum(self.table[time, state])
        return int(np.searchsorted(chances, random.random() * chances[-1], side="right"))

    @cached_property
    def _states(self) -> dict[bytes, int]:
        return {_code(nodes): state for state, nodes in enumerate(self.compromised)}


@dataclass(frozen=True)
class NetworkPlayer:
    """A policy π(o, t/T) of a continuous game; it leaves nothing to chance."""

    policy: NumpyPolicy

    def __call__(self, observation: np.ndarray, random: np.random.Generator) -> np.ndarray:
        """The action."""
        return self.policy(observation[:-1], float(observation[-1])).astype(np.float32)


def _code(nodes: np.ndarray) -> bytes:
    return np.packbits(nodes > 0.5).tobytes()
