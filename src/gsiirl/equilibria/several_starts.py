"""A search from several starts, which only the most promising one goes through to the end."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray, PyTree

TRIED = 0.5
"""Share of the steps that every start takes, before the search goes on with the most promising one."""


def best_of_starts(
    starts: PyTree,
    climb: Callable[[PyTree, PRNGKeyArray, int], PyTree],
    worth: Callable[[PyTree], Float[Array, ""]],
    key: PRNGKeyArray,
    steps: int,
) -> PyTree:
    """What all `steps` lead to from whichever start is worth most after the first `TRIED` of them.

    `starts` stand along a leading axis; `climb(start, key, number)` takes some steps from one.
    """
    trial_key, rest_key = jax.random.split(key)
    trial = int(TRIED * steps)
    tried = jax.vmap(lambda start: climb(start, trial_key, trial))(starts)
    best = jnp.argmax(jax.vmap(worth)(tried))
    return climb(jax.tree.map(lambda each: each[best], tried), rest_key, steps - trial)
