"""What the runner asks of an experiment: a game's description, and an algorithm of three pure functions."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from jaxtyping import Array, PRNGKeyArray, PyTree

Record = dict[str, Array]


class Ending(NamedTuple):
    """What one seed leaves behind when its last iteration is done; all arrays, so that the runner can vmap it."""

    record: Record
    """The last iteration's metrics: scalars, of the same names as those that `advance` records."""
    paths: dict[str, Array]
    """Columns of the sample trajectories: integers or floats, each of shape [trajectories, steps]."""
    learned: dict[str, Array]
    """Learned parameters: vectors, described by `PreparedRun.parameters`; empty where nothing is learned."""
    reward_map: dict[str, Array]
    """A learned reward beside the true one: columns `x`, `y`, `learned`, `true` of shape [points]; empty for none."""
    policies: dict[str, Array]
    """Weights of the networks that policies are, such as `learner.layers.0.weight`; empty where they are none."""


@dataclass(frozen=True)
class Algorithm:
    """One algorithm on one problem, for one seed; the runner vmaps it over seeds and compiles it.

    A state is a tree of arrays only (typed random keys included): what else a network or an optimiser holds belongs in
    the closures. Whatever `advance` draws must depend on `key` and the number of the iteration alone, so that a run cut
    into chunks is the same run.
    """

    init: Callable[[PRNGKeyArray], PyTree]
    """The state before the first iteration."""
    advance: Callable[[PyTree, PRNGKeyArray, Array, int], tuple[PyTree, Record]]
    """`advance(state, key, first, number)` does `number` iterations from `first` on and records each before its update:
    metrics of shape [number]. `first` is traced, `number` is not."""
    finish: Callable[[PyTree, PRNGKeyArray], Ending]
    """What the state amounts to after the last iteration."""


class Parameters(NamedTuple):
    """What makes a vector of learned parameters readable."""

    scale: float
    """Reward units of a parameter of 1."""
    names: tuple[str, ...]
    """A name for every entry."""


def _no_references() -> Record:
    return {}


@dataclass(frozen=True)
class PreparedRun:
    """One run of an experiment, ready for the runner."""

    game: dict[str, Any]
    """Content of `game.json`: what a report needs to draw the game and to judge what was learned. Two runs are compared
    in one figure when it is equal, so that it says nothing of the algorithm or of seeds."""
    algorithm: Algorithm
    iterations: int
    """Iterations to do; 0 for an algorithm that only has an ending."""
    chunk: int
    """Iterations compiled into one call, of about 10 s or less: the run is checkpointed, and can be interrupted,
    between calls."""
    references: Callable[[], Record] = _no_references
    """Metrics that are the same for all seeds and iterations; scalars."""
    parameters: dict[str, Parameters] = field(default_factory=dict[str, Parameters])
    """Of everything in `Ending.learned` its scale and names."""
