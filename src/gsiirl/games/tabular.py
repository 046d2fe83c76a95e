"""A tabular game given by its successors."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PRNGKeyArray

from gsiirl.errors import InputError
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import DensePayoff
from gsiirl.types import Sides


class TabularGame(AbstractTabularGame):
    """A game given by at most K successors of each (s, a_l, a_e); there is no dense P(s'|s,a).

    `successors` (S, A_l, A_e, K) are state indices, `probabilities` (S, A_l, A_e, K) sum to one over K, `initial` (S,)
    is P0, `horizon` is T.
    """

    successors: Int[Array, "S A_l A_e K"]
    probabilities: Float[Array, "S A_l A_e K"]
    initial: Float[Array, " S"]
    horizon: int = eqx.field(static=True)

    @classmethod
    def create(cls, successors: object, probabilities: object, initial: object, horizon: int) -> "TabularGame":
        """Check the tables and build the game.

        Raises:
            InputError: when a table's shape, a probability or a successor is impossible.
        """
        successor_table, probability_table = np.asarray(successors), np.asarray(probabilities, dtype=float)
        initial_table = np.asarray(initial, dtype=float)
        if successor_table.ndim != 4 or successor_table.shape != probability_table.shape:
            raise InputError(
                "successors",
                f"shape {successor_table.shape} beside probabilities of shape {probability_table.shape}",
                "give both the shape (states, learner's actions, expert's actions, successors)",
            )
        if horizon < 1:
            raise InputError("horizon", f"{horizon} is no number of steps", "give 1 or more")
        states = successor_table.shape[0]
        if initial_table.shape != (states,):
            raise InputError(
                "initial", f"shape {initial_table.shape}", f"give one probability for each of {states} states"
            )
        if successor_table.min() < 0 or successor_table.max() >= states:
            raise InputError("successors", "an index is no state", f"give indices from 0 to {states - 1}")
        for name, table in (("probabilities", probability_table), ("initial", initial_table)):
            if not np.isfinite(table).all() or table.min() < 0 or np.abs(table.sum(-1) - 1).max() > 1e-6:
                raise InputError(name, "do not form distributions", "give finite, non-negative values that sum to 1")
        return cls(
            successors=jnp.asarray(successor_table),
            probabilities=jnp.asarray(probability_table),
            initial=jnp.asarray(initial_table),
            horizon=horizon,
        )

    @property
    def number_of_actions(self) -> Sides[int]:
        return Sides(self.successors.shape[1], self.successors.shape[2])

    def continuation(self, values: Float[Array, " S"]) -> DensePayoff:
        return DensePayoff(jnp.sum(self.probabilities * values[self.successors], axis=-1))

    def advance(self, distribution: Float[Array, " S"], policies: Sides[Float[Array, "..."]]) -> Float[Array, " S"]:
        joint = jnp.einsum("s,sl,se->sle", distribution, policies.learner, policies.expert)
        return jnp.zeros_like(distribution).at[self.successors].add(joint[..., None] * self.probabilities)

    def reset(self, key: PRNGKeyArray) -> Int[Array, ""]:
        return jax.random.categorical(key, jnp.log(self.initial))

    def step(self, key: PRNGKeyArray, state: Int[Array, ""], actions: Sides[Int[Array, ""]]) -> Int[Array, ""]:
        chosen = state, actions.learner, actions.expert
        successor = jax.random.categorical(key, jnp.log(self.probabilities[chosen]))
        return self.successors[chosen][successor]
