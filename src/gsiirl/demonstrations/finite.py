"""Demonstrations of a finite game: whether the game can have made them, and the learner's policy."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array
from scipy.special import gammaln

from gsiirl.errors import InputError
from gsiirl.games.base import AbstractTabularGame
from gsiirl.types import Sides, Trajectories

CHANCE = 1e-9
"""The probability, at most, that an interaction in which the learner did play the policy gives a warning."""


def checked(seen: Any, number: int, game: AbstractTabularGame) -> Trajectories:
    """Demonstrations of a user's own expert, with the library's types.

    Raises:
        InputError: they do not fit the game.
    """
    field = "demonstrations"
    if not isinstance(seen, Trajectories):
        raise InputError(field, f"are {type(seen).__name__}", "return gsiirl.types.Trajectories")
    shape = (number, game.horizon)
    limits = {
        "states": (seen.states, game.number_of_states),
        "actions.learner": (seen.actions.learner, game.number_of_actions.learner),
        "actions.expert": (seen.actions.expert, game.number_of_actions.expert),
    }
    arrays = {}
    for name, (values, _) in limits.items():
        array = np.asarray(values)
        if array.shape != shape or array.dtype.kind not in "iu":
            raise InputError(
                f"{field}.{name}", f"is {array.dtype} of shape {array.shape}", f"give integers of shape {shape}"
            )
        arrays[name] = array
    mask = np.asarray(seen.mask)
    if mask.shape != shape or mask.dtype != bool:
        raise InputError(f"{field}.mask", f"is {mask.dtype} of shape {mask.shape}", f"give booleans of shape {shape}")
    states, given = arrays["states"], mask
    known = (states >= 0) & (states < game.number_of_states)
    over = np.zeros(shape, bool)
    if game.terminal is not None:
        over = known & np.asarray(game.terminal)[np.where(known, states, 0)]
    mask = mask & ~np.logical_or.accumulate(over, axis=1)
    for wrong, said in (
        (
            ~given[:, :1] & ~(over & (np.asarray(game.initial)[np.where(known, states, 0)] > 0))[:, :1],
            "has no first step",
        ),
        (given[:, 1:] & ~given[:, :-1], "goes on after a step that is masked"),
    ):
        if wrong.any():
            problem = f"cannot be: episode {np.argwhere(wrong)[0][0]} {said}"
            raise InputError(f"{field}.mask", problem, "give True up to the end of each episode, then False")
    for name, (_, limit) in limits.items():
        wrong = mask & ((arrays[name] < 0) | (arrays[name] >= limit))
        if wrong.any():
            raise InputError(
                f"{field}.{name}", f"holds {arrays[name][wrong][0]}", f"give numbers from 0 to {limit - 1}"
            )
    arrays = {name: np.where(mask, array, 0) for name, array in arrays.items()}
    for side, allowed in (("learner", game.allowed.learner), ("expert", game.allowed.expert)):
        if allowed is None:
            continue
        chosen = arrays[f"actions.{side}"]
        wrong = mask & ~np.asarray(allowed)[arrays["states"], chosen]
        if wrong.any():
            episode, step = np.argwhere(wrong)[0]
            raise InputError(
                f"{field}.actions.{side}",
                f"is {chosen[episode, step]} in state {arrays['states'][episode, step]}, which is forbidden there",
                f"demonstrate allowed actions, or mend {side}_actions of the game",
            )
    # Where an episode ends in a terminal state, that it arrives there counts, and nothing after.
    _check_possible(arrays, mask, np.where(known & given, states, -1), game)
    whole = {name: jnp.asarray(array, jnp.int64) for name, array in arrays.items()}
    return Trajectories(
        states=whole["states"],
        actions=Sides(whole["actions.learner"], whole["actions.expert"]),
        mask=jnp.asarray(mask),
    )


def _check_possible(
    seen: dict[str, np.ndarray], mask: np.ndarray, states: np.ndarray, game: AbstractTabularGame
) -> None:
    """See that episodes begin and go on as the game allows; `states` are −1 where none was seen.

    Raises:
        InputError: one does not: something was recorded in another order, or the game is not the one that was played.
    """
    mend = "record the state before each step, and who did what; or mend the game"
    begun = (states[:, 0] >= 0) & (np.asarray(game.initial)[states[:, 0]] == 0)
    if begun.any():
        episode = int(np.argmax(begun))
        where = f"episode {episode} begins in state {states[episode, 0]}"
        raise InputError("demonstrations.states", f"{where}, where the game never begins", mend)
    episodes, steps = np.nonzero(mask[:, :-1] & (states[:, 1:] >= 0))
    before = {name: array[episodes, steps] for name, array in seen.items()}
    following = states[episodes, steps + 1]
    actions = Sides(before["actions.learner"], before["actions.expert"])
    wrong = np.flatnonzero(~game.possible(before["states"], actions, following))
    if wrong.size:
        first = wrong[0]
        where = f"episode {episodes[first]} goes at step {steps[first]} from state {before['states'][first]}"
        done = f"by learner's action {actions.learner[first]} and expert's action {actions.expert[first]}"
        problem = f"{where} to state {following[first]} {done}, which the game never does"
        raise InputError("demonstrations.states", problem, mend)


def doubts(seen: Trajectories, policy: Array | np.ndarray, game: AbstractTabularGame) -> dict[str, str]:
    """What is odd, in a line for each kind: learner's actions that are not drawn from `policy` (T, S, A_l)."""
    if evidence(seen, policy, game) < -np.log(CHANCE):
        return {}
    return {
        "learner": (
            "demonstrations.actions.learner are not drawn from the policy that demonstrate was given (by chance an "
            f"interaction looks so at most once in {1 / CHANCE:,.0f}): what the expert did is learned from as its "
            "answer to that policy all the same; draw the learner's actions from it, or give other episodes by hand, "
            "with the policies that were played"
        )
    }


def evidence(seen: Trajectories, policy: Array | np.ndarray, game: AbstractTabularGame) -> float:
    """log of an e-value against the claim that the learner's actions are drawn from `policy` (T, S, A_l).

    log [½ Π q(a|t, s) + ½ K(a)] − log Π π(a|t, s), over all steps that count. q is half of π and half uniform; K is the
    Krichevsky-Trofimov mixture of all policies that look at the state alone. Both are distributions of the actions,
    whatever states come, so that P(evidence ≥ x) ≤ e^(−x) where π was played (Markov's inequality). Each action must be
    a new draw from π: copies of one episode count as evidence against it.
    """
    mask = np.asarray(seen.mask)
    states, actions = (np.asarray(array)[mask] for array in (seen.states, seen.actions.learner))
    policy = np.asarray(policy, float)
    if not states.size:
        return 0.0
    played = policy[np.nonzero(mask)[1], states, actions]
    allowed = game.allowed.learner
    ways = np.full(policy.shape[1], policy.shape[2]) if allowed is None else np.asarray(allowed).sum(axis=1)
    counts = np.zeros(policy.shape[1:])
    np.add.at(counts, (states, actions), 1)
    with np.errstate(divide="ignore"):
        log_played = np.log(played)
    mixed = np.log(played / 2 + 1 / (2 * ways[states])).sum()
    by_state = (gammaln(counts + 0.5) - gammaln(0.5)).sum(axis=1) + gammaln(ways / 2)
    frequent = (by_state - gammaln(counts.sum(axis=1) + ways / 2)).sum()
    return float(np.logaddexp(mixed, frequent) - np.log(2) - log_played.sum())
