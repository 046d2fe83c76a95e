"""Demonstrations of a continuous game: whether they have its types, go on as it does, and the learner's policy."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, PyTree

from gsiirl.errors import InputError
from gsiirl.games.base import AbstractContinuousGame
from gsiirl.games.rollout import Policy
from gsiirl.types import Sides, Transition

ROUGH_STEP = 0.01
"""A share of what moves in a step, from which on a warning says that an expert's episodes are not quite the game's."""
OTHER_STEP = 0.5
"""The share from which on they are not the game's at all."""
ROUGH_ACTION = 0.1
"""How far on average, in units of the largest action, the learner may be from its policy without a warning."""


def checked(seen: Any, number: int, game: AbstractContinuousGame[Any]) -> Transition:
    """Demonstrations of a user's own expert, with the types of the game.

    Raises:
        InputError: they do not fit the game.
    """
    field = "demonstrations"
    if not isinstance(seen, Transition):
        raise InputError(field, f"are {type(seen).__name__}", "return a gsiirl.types.Transition")
    state = eqx.filter_eval_shape(game.reset, jax.random.key(0))
    sizes = game.action_size
    actions = Sides(jnp.zeros(sizes.learner, jnp.float32), jnp.zeros(sizes.expert, jnp.float32))
    leaves, structure = jax.tree.flatten_with_path(Transition(state, actions, state))
    if jax.tree.structure(seen) != structure:
        raise InputError(field, "do not have the parts of the game's states and actions", "give states of the game")
    arrays = []
    for (path, leaf), given in zip(leaves, jax.tree.leaves(seen), strict=True):
        array, shape, name = np.asarray(given), (number, game.horizon, *leaf.shape), field + jax.tree_util.keystr(path)
        if array.shape != shape or array.dtype.kind not in "iufb":
            raise InputError(name, f"is {array.dtype} of shape {array.shape}", f"give numbers of shape {shape}")
        if not np.isfinite(array).all():
            raise InputError(name, "is not finite", "give finite numbers")
        if path[0] == jax.tree_util.GetAttrKey("actions") and np.abs(array).max(initial=0.0) > 1.0 + 1e-6:
            raise InputError(name, f"holds {array.flat[np.abs(array).argmax()]:.3g}", "give actions from -1 to 1")
        arrays.append(jnp.asarray(array, leaf.dtype))
    return jax.tree.unflatten(structure, arrays)


def doubts(seen: Transition, policy: Policy, game: AbstractContinuousGame[Any]) -> dict[str, str]:
    """What is odd, in a line for each kind: episodes that are not near what the game and `policy` would have made."""
    said = {}
    off, entry = away_from_steps(seen, game)
    if off > ROUGH_STEP:
        said["following"] = (
            f"demonstrations.following{entry} ends {off:.0%} of what moves in a step away from where the game's step "
            "ends: the learner plans in the game, so that what it learns is only as good as the game; mend its step, "
            "or the states that are recorded"
        )
    asked = _actions(game, policy, seen.state)
    if (off := float(np.abs(np.asarray(seen.actions.learner) - np.asarray(asked)).mean())) > ROUGH_ACTION:
        said["learner"] = (
            f"demonstrations.actions.learner are {off:.2g} on average away from those of the policy that demonstrate "
            "was given: what the expert did is learned from as its answer to that policy all the same; play that "
            "policy, or record what was really done"
        )
    return said


def away_from_steps(seen: Transition, game: AbstractContinuousGame[Any]) -> tuple[float, str]:
    """How far from the game's steps those of somebody's own expert end, and which entry of the state is farthest.

    mean |P(s, a) − s'| / mean |s' − s|, the most of all entries of a state.

    Raises:
        InputError: a step does not begin where the one before it ended, or the steps are not the game's.
    """
    entries = _entries(seen, _steps(game, seen.state, seen.actions))
    if not all(np.isfinite(said).all() for _, _, said, _ in entries.values()):
        raise InputError("game", "has a step that is not finite, from a state of demonstrations", "mend its step")
    ways = [
        max(np.abs(after - before).mean(), np.abs(said - before).mean()) for before, after, said, _ in entries.values()
    ]
    # What is nothing beside the entry that moves most does not count, nor does rounding.
    nothing = 1e-6 * max(ways, default=0.0)
    most, farthest = 0.0, ""
    for (entry, (before, after, said, rounding)), way in zip(entries.items(), ways, strict=True):
        slack = rounding + nothing
        gaps = np.abs(after[:, :-1] - before[:, 1:])
        if gaps.max(initial=0.0) > OTHER_STEP * way + slack:
            episode, step = np.unravel_index(gaps.argmax(), gaps.shape)
            problem = f"of episode {episode} at step {step + 1} is not where step {step} ended"
            raise InputError(f"demonstrations.state{entry}", problem, "record the state before and after each step")
        missed = np.abs(said - after)
        off = float(max(missed.mean() - slack, 0.0) / way) if way else 0.0
        # An entry that seldom jumps may jump a step early in a world that is nearly the game.
        often = (missed > OTHER_STEP * way + slack).mean()
        if not off <= OTHER_STEP and not often <= ROUGH_STEP:
            problem = f"ends {off:.0%} of what moves in a step away from where the game's step ends"
            mend = "record actions as Sides(learner, expert) and the state before and after them, or mend the game"
            raise InputError(f"demonstrations.following{entry}", problem, mend)
        most, farthest = max((most, farthest), (off, entry))
    return most, farthest


def _entries(seen: Transition, expected: PyTree) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray, float]]:
    """For each number of a state, by its name: before and after the steps and after those of the game, (episodes, T).

    Then what rounding in single precision does to the array that it is in. The numbers of an array have a name each, as
    their units may differ: (x, y, speed).
    """
    entries = {}
    leaves, _ = jax.tree.flatten_with_path(seen.state)
    for (path, before), *others in zip(leaves, jax.tree.leaves(seen.following), jax.tree.leaves(expected), strict=True):
        before, after, said = (np.asarray(each, float) for each in (before, *others))
        rounding = 4e-7 * np.abs(after).mean(axis=(0, 1)).max(initial=0.0)
        for place in np.ndindex(*after.shape[2:]):
            name, at = jax.tree_util.keystr(path) + (str(list(place)) if place else ""), (..., *place)
            entries[name] = before[at], after[at], said[at], rounding
    return entries


@eqx.filter_jit
def _steps(game: AbstractContinuousGame[Any], states: PyTree, actions: Sides[Array]) -> PyTree:
    """The states that follow (episodes, T) states."""
    return jax.vmap(jax.vmap(game.step))(states, actions)


@eqx.filter_jit
def _actions(game: AbstractContinuousGame[Any], policy: Policy, states: PyTree) -> Array:
    """What the learner's policy does in (episodes, T) states."""
    times = jnp.arange(game.horizon, dtype=jnp.float32) / game.horizon
    return jax.vmap(jax.vmap(lambda state, time: policy(game.observe(state).learner, time)), (0, None))(states, times)
