"""What the learner remembers of its interactions: a uniform sample of all that always holds the newest."""

from typing import Generic, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

Kept = TypeVar("Kept")


class Played(eqx.Module):
    """What is kept of one interaction in a tabular game: the learner's policy as played and the demonstrations' μ̂_e."""

    learner_policy: Float[Array, "*M T S A_l"]
    demonstrated: Float[Array, "*M m"]


class Memory(eqx.Module, Generic[Kept]):
    """Up to M interactions, along a leading axis of `kept`.

    Slot 0 is the newest; the others are a uniform sample without replacement from all earlier ones (Vitter's algorithm
    R).
    """

    kept: Kept
    count: Int[Array, ""]

    @classmethod
    def empty(cls, capacity: int, like: Kept) -> "Memory[Kept]":
        """No interaction yet; every slot looks like `like`."""
        kept = jax.tree.map(lambda leaf: jnp.repeat(jnp.asarray(leaf)[None], capacity, axis=0), like)
        return cls(kept, jnp.zeros((), jnp.int32))

    @property
    def capacity(self) -> int:
        """M."""
        return jax.tree.leaves(self.kept)[0].shape[0]

    @property
    def held(self) -> Int[Array, ""]:
        """How many interactions are held; the slots after them hold nothing yet."""
        return jnp.minimum(self.count, self.capacity)

    @property
    def filled(self) -> Bool[Array, " M"]:
        """Which slots hold an interaction."""
        return jnp.arange(self.capacity, dtype=self.count.dtype) < self.count

    def remember(self, key: PRNGKeyArray, newest: Kept) -> "Memory[Kept]":
        """Take in the newest; the one before it enters the reservoir of earlier ones, or is forgotten."""
        kept = self.capacity - 1
        # The interaction in slot 0 is the `count`-th ever; it takes a free slot, or a random one with the right chance.
        draw = jax.random.randint(key, (), 0, jnp.maximum(self.count, 1), self.count.dtype)
        place = jnp.where(self.count <= kept, self.count, draw + 1)
        keeps = (self.count >= 1) & (place <= kept)
        place = jnp.clip(place, 0, kept)

        def moved(stored: Array, newest: Array) -> Array:
            retired = jnp.where(keeps, stored[0], stored[place])
            return stored.at[place].set(retired).at[0].set(newest)

        return Memory(jax.tree.map(moved, self.kept, newest), self.count + 1)
