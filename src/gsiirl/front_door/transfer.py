"""A policy for a changed game from what was learned in another (`policy_for` of a result)."""

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, PRNGKeyArray

from gsiirl.arguments import seed_of
from gsiirl.commitment.anew import best_commitment
from gsiirl.commitment.objective import Commitment
from gsiirl.compilation import QUICKLY
from gsiirl.equilibria.anew import trained_anew
from gsiirl.equilibria.pathwise import Pathwise
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.errors import InputError
from gsiirl.front_door.learned_reward import LearnedReward
from gsiirl.games.base import AbstractContinuousGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.problems.continuous_problem import ContinuousProblem, Nothing, single_precision
from gsiirl.problems.problem import Problem
from gsiirl.rewards.continuous import AbstractTransitionReward, LinearTransitionReward, TransitionReward
from gsiirl.types import Sides, Transition

EPISODES = 1000
"""Over which the learner's return is averaged where a search has to choose between networks."""


def policy_for(
    problem: object, before: Problem, expert: LearnedReward, dependent: LearnedReward, seed: int
) -> np.ndarray:
    """The best commitment (T, S, A_l) found in the game of `problem`, under rewards learned in that of `before`."""
    if not isinstance(problem, Problem):
        raise InputError("problem", f"is {type(problem).__name__}", "give a gsiirl.Problem of a finite game")
    own = carried_over("expert", problem.expert_names, before.expert_names, expert.weights)
    fitted = carried_over("dependent", problem.dependent_names, before.dependent_names, dependent.weights)
    # What was learned without a temperature is in units of it.
    temperature = 1.0 if before.temperature is None else problem.temperature or before.temperature
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        learner_reward = problem.own_reward + problem.dependent_features.payoff(jnp.asarray(fitted))
        expert_reward = problem.expert_features.payoff(jnp.asarray(own / temperature))
        commitment = Commitment(problem.game, learner_reward, problem.discount)
        found = _best(*jax.tree.map(jnp.asarray, (commitment, expert_reward)), jax.random.key(seed_of(seed)))
        return np.asarray(found)


def carried_over(kind: str, wanted: Sequence[str], known: Sequence[str], weights: np.ndarray) -> np.ndarray:
    """The weights of the names `wanted`, from those of the names `known`.

    Raises:
        InputError: one of them was not learned.
    """
    if wanted == known:
        return weights
    places = {name: place for place, name in enumerate(known)}
    for name in wanted:
        if name not in places:
            problem = f"its {kind}_features have a '{name}', of which nothing was learned"
            raise InputError("problem", problem, "give features of the names that the result has")
    return weights[[places[name] for name in wanted]]


@partial(jax.jit, compiler_options=QUICKLY)
def _best(commitment: Commitment, expert_reward: AbstractPayoff, key: PRNGKeyArray) -> Array:
    return best_commitment(commitment, expert_reward, key)


def network_for(
    problem: object,
    before: ContinuousProblem,
    parameters: Sides[np.ndarray],
    pair: Sides[PolicyNetwork],
    solver: Pathwise,
    key: PRNGKeyArray,
    steps: int,
) -> PolicyNetwork:
    """The learner of the pair that `solver` comes to in the game of `problem`, under rewards learned in `before`.

    `parameters` are θ of r_ld and of r_e, in the unit ball; `pair` is what the result ended with.
    """
    if not isinstance(problem, ContinuousProblem):
        raise InputError("problem", f"is {type(problem).__name__}", "give a gsiirl.Problem of a continuous game")
    with single_precision():
        theirs, ours = _sizes(problem.game), _sizes(before.game)
        if theirs != ours:
            raise InputError("problem.game", f"has {_said(theirs)}", f"keep to those of the result: {_said(ours)}")
        learned = Sides(
            taken_along("dependent", problem.dependent_reward, before.dependent_reward, parameters.learner),
            taken_along("expert", problem.expert_reward, before.expert_reward, parameters.expert),
        )
        solver = replace(solver, game=problem.game, discount=problem.discount)
        return _trained(solver, problem, learned, pair, key, steps)


def taken_along(
    kind: str, wanted: AbstractTransitionReward, known: AbstractTransitionReward, parameters: np.ndarray
) -> TransitionReward:
    """The reward `wanted` of a changed game, with what was learned of the reward `known` as its parameters.

    Linear ones get their weights by name and in reward units, whatever their scales. Others must have the settings that
    the known one has, features apart.

    Raises:
        InputError: `wanted` has a weight that was not learned, or is of another kind.
    """
    if type(wanted) is LinearTransitionReward and type(known) is LinearTransitionReward:
        if isinstance(wanted.features, Nothing) and not isinstance(known.features, Nothing):
            mend = "give dependent_features, and a dependent_value of any kind: the result has learned its own"
            raise InputError("problem.dependent_features", "is None", mend)
        weights = known.scale * carried_over(kind, wanted.names, known.names, parameters)
        return eqx.Partial(wanted, jnp.asarray(weights / wanted.scale, jnp.float32))
    ours, theirs = _settings(known), _settings(wanted)
    if theirs != ours:
        differing = [name for name in {**ours, **theirs} if ours.get(name) != theirs.get(name)]
        problem = f"differs from the reward that was learned in: {', '.join(differing)}"
        raise InputError(f"problem.{kind}_features", problem, f"give a {type(known).__name__} like the first")
    return eqx.Partial(wanted, jnp.asarray(parameters, jnp.float32))


def _settings(reward: AbstractTransitionReward) -> dict[str, object]:
    """Its kind, the names of its weights, and its numbers."""
    numbers = {each.name: getattr(reward, each.name) for each in fields(reward)}
    return {
        "kind": type(reward).__name__,
        "names of weights": tuple(reward.names),
        **{name: value for name, value in numbers.items() if isinstance(value, int | float | str)},
    }


def _sizes(game: AbstractContinuousGame) -> tuple[int, ...]:
    """Lengths of what the learner and the expert observe, and of their actions."""
    seen = eqx.filter_eval_shape(lambda key: game.observe(game.reset(key)), jax.random.key(0))
    return *(each.shape[0] for each in (seen.learner, seen.expert)), game.action_size.learner, game.action_size.expert


def _said(sizes: tuple[int, ...]) -> str:
    return "observations of {} and {} numbers, actions of {} and {}".format(*sizes)


@eqx.filter_jit
def _trained(
    solver: Pathwise,
    problem: ContinuousProblem,
    learned: Sides[TransitionReward],
    pair: Sides[PolicyNetwork],
    key: PRNGKeyArray,
    steps: int,
) -> PolicyNetwork:
    """Compiled once for a problem: its own reward may be any function."""

    def learner_reward(seen: Transition) -> Array:
        return learned.learner(seen) + problem.own_reward(seen)

    # The solver goes through both rewards as leaves, which trees of numbers are not.
    rewards: Sides[TransitionReward] = Sides(learner_reward, lambda seen: learned.expert(seen))
    return trained_anew(solver, rewards, pair, key, steps, EPISODES).learner
