"""The few records every part of the library speaks in."""

from typing import Any, Generic, Self, TypeVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PyTree
from numpy.typing import ArrayLike

Value = TypeVar("Value", covariant=True)
AnyArray = Array | np.ndarray
"""JAX's arrays or NumPy's; the front door keeps NumPy's, in double precision whatever JAX is set to."""

Number = float | Float[Array, ""]
"""A number that may be traced."""


class Sides(eqx.Module, Generic[Value]):
    """A value for each of the two sides of a game."""

    learner: Value
    expert: Value


Policies = Sides[Float[Array, "..."]]
"""Time-indexed policies: `learner` π_l(a_l|s,t) of shape (T, S, A_l), `expert` π_e(a_e|s,t) of shape (T, S, A_e)."""


class Trajectories(eqx.Module):
    """Episodes of equal length T; `d` of them along a leading axis.

    `states` and `actions` are indices into the game's states and actions, whole numbers from 0: the state before each
    step, and what both sides did there. `mask` is True up to an episode's end; what stands after it does not count.
    """

    states: Int[Array, "*d T"]
    actions: Sides[Int[Array, "*d T"]]
    mask: Bool[Array, "*d T"]

    @classmethod
    def from_arrays(
        cls, states: ArrayLike, learner: ArrayLike, expert: ArrayLike, mask: ArrayLike | None = None
    ) -> Self:
        """Episodes from arrays of NumPy, (d, T) each; without `mask` every episode lasts T steps."""
        visited = jnp.asarray(states)
        lasts = jnp.ones(visited.shape, bool) if mask is None else jnp.asarray(mask)
        return cls(visited, Sides(jnp.asarray(learner), jnp.asarray(expert)), lasts)


class Interaction(eqx.Module):
    """What one interaction leaves the learner: the policy it played, and the episodes that it saw.

    In a finite game the policy is a table (T, S, A_l) and the episodes are `Trajectories`; in a continuous one, a
    network and `Transition`s (axes d, T). `probes` are the episodes at the learner's probes, along a leading axis.
    """

    learner_policy: PyTree
    demonstrations: Any
    probes: Any = None


class Transition(eqx.Module):
    """One step (s, a, s') of a continuous game; an episode is T of them along a leading axis, more axes come before it.

    `state` and `following` are states of the game; each side's action is a vector in [−1, 1]^A.
    """

    state: PyTree
    actions: Sides[Float[Array, "..."]]
    following: PyTree
