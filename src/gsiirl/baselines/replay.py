"""What MADDPG has lived through: the newest steps, without rewards."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Int, PRNGKeyArray

from gsiirl.types import Transition


class Experience(eqx.Module):
    """A step (s, a, s') and the time t at which it was made; many of them along leading axes."""

    transition: Transition
    time: Int[Array, "*b"]


class Replay(eqx.Module):
    """The newest steps of E environments that step together: a ring of R rounds, the oldest overwritten first.

    No rewards are stored: whoever samples computes them, under whatever rewards are asked about then.
    """

    stored: Experience
    """Leaves of shape (R, E, ...)."""
    rounds: Int[Array, ""]
    """How many rounds were ever added."""

    @classmethod
    def create(cls, example: Experience, rounds: int, environments: int) -> "Replay":
        """Nothing yet, with room for `rounds` rounds of steps like `example`."""
        empty = jax.tree.map(lambda leaf: jnp.zeros((rounds, environments, *leaf.shape), leaf.dtype), example)
        return cls(empty, jnp.zeros((), jnp.int32))

    def add(self, experience: Experience) -> "Replay":
        """With one more round: `experience` has E steps along its leading axis."""
        place = self.rounds % self.stored.time.shape[0]
        stored = jax.tree.map(
            lambda all_rounds, round_: jax.lax.dynamic_update_index_in_dim(all_rounds, round_, place, 0),
            self.stored,
            experience,
        )
        return Replay(stored, self.rounds + 1)

    def sample(self, key: PRNGKeyArray, number: int) -> Experience:
        """`number` steps along a leading axis, drawn with replacement from what is stored; something must be."""
        capacity, environments = self.stored.time.shape
        filled = jnp.minimum(self.rounds, capacity) * environments
        drawn = jax.random.randint(key, (number,), 0, filled, jnp.int32)
        return jax.tree.map(lambda leaf: leaf.reshape(-1, *leaf.shape[2:])[drawn], self.stored)
