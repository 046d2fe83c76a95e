"""What the learner remembers of its interactions: a uniform reservoir that always holds the newest."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray


class Memory(eqx.Module):
    """Up to M interactions: the learner's policy as played and the demonstrations' μ̂_e.

    Slot 0 is the newest; the others are a uniform sample without replacement from all earlier ones (Vitter's
    algorithm R).
    """

    learner_policies: Float[Array, "M T S A_l"]
    demonstrated: Float[Array, "M m"]
    count: Int[Array, ""]

    @classmethod
    def empty(cls, capacity: int, policy_shape: tuple[int, int, int], parameters: int, dtype: jnp.dtype) -> "Memory":
        """No interaction yet; `policy_shape` is (T, S, A_l)."""
        uniform = jnp.full((capacity, *policy_shape), 1.0 / policy_shape[-1], dtype)
        return cls(uniform, jnp.zeros((capacity, parameters), dtype), jnp.zeros((), jnp.int32))

    @property
    def filled(self) -> Bool[Array, " M"]:
        """Which slots hold an interaction."""
        return jnp.arange(self.demonstrated.shape[0], dtype=self.count.dtype) < self.count

    def remember(
        self, key: PRNGKeyArray, learner_policy: Float[Array, "T S A_l"], demonstrated: Float[Array, " m"]
    ) -> "Memory":
        """Take in the newest; the one before it enters the reservoir of earlier ones, or is forgotten."""
        kept = self.demonstrated.shape[0] - 1
        # The interaction in slot 0 is the `count`-th ever; it takes a free slot, or a random one with the right chance.
        draw = jax.random.randint(key, (), 0, jnp.maximum(self.count, 1), self.count.dtype)
        place = jnp.where(self.count <= kept, self.count, draw + 1)
        keeps = (self.count >= 1) & (place <= kept)
        place = jnp.clip(place, 0, kept)

        def moved(stored: Array, newest: Array) -> Array:
            retired = jnp.where(keeps, stored[0], stored[place])
            return stored.at[place].set(retired).at[0].set(newest)

        return Memory(
            moved(self.learner_policies, learner_policy), moved(self.demonstrated, demonstrated), self.count + 1
        )
