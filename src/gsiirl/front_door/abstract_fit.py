"""What `fit` is for both kinds of games: the run that is asked for, and whose expert is met."""

import abc
from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar, overload

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Key

from gsiirl.arguments import seed_of, whole_number
from gsiirl.errors import InputError

Expert = TypeVar("Expert", contravariant=True)
One = TypeVar("One")
Many = TypeVar("Many")


Callback = Callable[[int, dict[str, np.ndarray]], object]
"""Who is told of every round: its number, from 1 on, and what is recorded of it, arrays of shape [seeds, ...]."""


class Asked(NamedTuple):
    """The run that is asked for: `iterations` rounds of `trajectories` episodes, for each of the `seeds`."""

    iterations: int
    trajectories: int
    seeds: range
    progress: bool
    callback: Callback | None = None

    def tell(self, iteration: int, row: dict[str, np.ndarray]) -> None:
        """Tell whoever asked for it of a round that is over."""
        if self.callback is not None:
            self.callback(iteration, dict(row))

    def keys(self) -> Key[Array, "seeds 3"]:
        """Each seed's keys for its start, its rounds and its end."""
        each_seed = jnp.asarray(np.arange(self.seeds.start, self.seeds.stop), jnp.int32)
        return jax.vmap(lambda each: jax.random.split(jax.random.key(each), 3))(each_seed)


class AbstractGSIIRL(abc.ABC, Generic[Expert, One, Many]):
    """A learner of one kind of game; one seed gives `One`, several give `Many`."""

    @overload
    def fit(
        self,
        expert: Expert,
        iterations: int = ...,
        trajectories: int = ...,
        seed: int = ...,
        *,
        seeds: None = ...,
        progress: bool = ...,
        callback: Callback | None = ...,
    ) -> One: ...

    @overload
    def fit(
        self,
        expert: Expert,
        iterations: int = ...,
        trajectories: int = ...,
        seed: int = ...,
        *,
        seeds: int,
        progress: bool = ...,
        callback: Callback | None = ...,
    ) -> Many: ...

    def fit(
        self,
        expert: Expert,
        iterations: int = 50,
        trajectories: int = 100,
        seed: int = 0,
        *,
        seeds: int | None = None,
        progress: bool = True,
        callback: Callback | None = None,
    ) -> One | Many:
        """Live with `expert` for `iterations` rounds of `trajectories` episodes, and say what was learned.

        `seeds` asks for as many runs, of the seeds from `seed` on. An expert of the library is compiled; any other
        object with `demonstrate(policy, number, key)` is called, once a round and seed. `callback(iteration, metrics)`
        is called after every round with what is recorded of it: arrays by name, each with an axis of seeds.

        Raises:
            InputError: an argument cannot be, or a demonstration does not fit the game.
        """
        number, episodes = whole_number("iterations", iterations, 1), whole_number("trajectories", trajectories, 1)
        several = 1 if seeds is None else whole_number("seeds", seeds, 1)
        first = seed_of(seed, several)
        if callback is not None and not callable(callback):
            raise InputError("callback", f"is {type(callback).__name__}", "give a function of a number and a dict")
        results = self._lived(expert, Asked(number, episodes, range(first, first + several), progress, callback))
        return results[0] if seeds is None else self._together(results)

    @abc.abstractmethod
    def _lived(self, expert: Expert, asked: Asked) -> list[One]:
        """The result of every seed."""

    @abc.abstractmethod
    def _together(self, results: list[One]) -> Many:
        """The results of several seeds as one."""
