"""A pair of networks trained anew where rewards or dynamics have changed, from a known pair and from a random one."""

from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.equilibria.pathwise import Ascent, Pathwise, policies_of
from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.equilibria.several_starts import best_of_starts
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.rewards.continuous import TransitionReward, mean_return
from gsiirl.types import Sides


def trained_anew(
    solver: Pathwise,
    rewards: Sides[TransitionReward],
    before: Sides[PolicyNetwork],
    key: PRNGKeyArray,
    steps: int,
    episodes: int,
) -> Sides[PolicyNetwork]:
    """The pair that `steps` steps of `solver` lead to from `before`, or from random networks.

    Halfway the search goes on with the pair under which the learner earns more, a mean over `episodes`.
    """
    start_key, ascent_key, test_key = jax.random.split(key, 3)

    def climb(pair: Sides[Ascent], key: PRNGKeyArray, steps: int) -> Sides[Ascent]:
        return solver.ascend(pair, rewards, key, steps)[0]

    def promise(pair: Sides[Ascent]) -> Float[Array, ""]:
        return promised(solver, rewards.learner, policies_of(pair), test_key, episodes)

    starts = stacked(solver.init_at(before), solver.init(start_key))
    return policies_of(best_of_starts(starts, climb, promise, ascent_key, steps))


def promised(
    solver: Pathwise, reward: TransitionReward, pair: Sides[PolicyNetwork], key: PRNGKeyArray, episodes: int
) -> Float[Array, ""]:
    """What the learner expects to earn: its discounted return under `reward`, a mean over `episodes`."""
    starts = initial_states(solver.game, key, episodes)
    return mean_return(reward, episodes_from(solver.game, pair, starts), solver.discount)


def stacked(one: Ascent | Sides[Ascent], other: Ascent | Sides[Ascent]) -> Any:
    """Two starts of a search along a leading axis."""
    return jax.tree.map(lambda *leaves: jnp.stack(leaves), one, other)
