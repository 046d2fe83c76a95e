"""A policy for a changed game from what was learned in another (`Result.policy_for`)."""

from collections.abc import Sequence
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, PRNGKeyArray

from gsiirl.commitment.anew import best_commitment
from gsiirl.commitment.objective import Commitment
from gsiirl.compilation import QUICKLY
from gsiirl.errors import InputError
from gsiirl.front_door.learned_reward import LearnedReward
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.problems.problem import Problem


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
        found = _best(*jax.tree.map(jnp.asarray, (commitment, expert_reward)), jax.random.key(seed))
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
