"""What a game is: dynamics alone. Rewards live outside (see `gsiirl.rewards`)."""

import abc
from typing import Generic, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import AnyArray, Sides

State = TypeVar("State")
FORBIDDEN = -1e30
"""The value of an action that may not be chosen: e to the power of it is exactly 0, and its derivative is no NaN."""


def only_allowed(values: Float[Array, "*b S A"], allowed: Bool[Array, "S A"] | None) -> Float[Array, "*b S A"]:
    """Action values with `FORBIDDEN` for the actions that may not be chosen."""
    return values if allowed is None else jnp.where(jnp.broadcast_to(allowed, values.shape), values, FORBIDDEN)


def learner_policy(game: "AbstractTabularGame", logits: Float[Array, "T S A_l"]) -> Float[Array, "T S A_l"]:
    """π_l ∝ exp(logits) over the actions that the learner may choose."""
    return jax.nn.softmax(only_allowed(logits, game.allowed.learner), axis=-1)


def uniform_policy(game: "AbstractTabularGame") -> Float[Array, "T S A_l"]:
    """The learner's policy that chooses every allowed action equally often."""
    shape = (game.horizon, game.number_of_states, game.number_of_actions.learner)
    return learner_policy(game, jnp.zeros(shape, game.initial.dtype))


class AbstractTabularGame(eqx.Module):
    """A two-sided finite-horizon Markov game with S states and A_l, A_e actions.

    A subclass says how values flow back (`continuation`), how mass flows forward (`advance`, its transpose), and how
    one step is sampled (`step`).
    """

    horizon: eqx.AbstractVar[int]
    initial: eqx.AbstractVar[Float[AnyArray, " S"]]

    def __repr__(self) -> str:
        actions = self.number_of_actions
        sizes = f"{self.number_of_states} states, {actions.learner} x {actions.expert} actions"
        return f"{type(self).__name__}({sizes}, {self.horizon} steps)"

    @property
    @abc.abstractmethod
    def number_of_actions(self) -> Sides[int]:
        """A_l and A_e."""

    @property
    def number_of_states(self) -> int:
        """S."""
        return self.initial.shape[0]

    @property
    def allowed(self) -> Sides[Bool[Array, "S A"] | None]:
        """Which actions each side may choose in a state; None where it may choose all."""
        return Sides(None, None)

    @property
    def policy_size(self) -> int:
        """T S (A_l + A_e): numbers of both sides' policies."""
        actions = self.number_of_actions
        return self.horizon * self.number_of_states * (actions.learner + actions.expert)

    @property
    def terminal(self) -> Bool[Array, " S"] | None:
        """States on whose arrival an episode is over; None where there are none."""
        return None

    def alive(self, values: Float[Array, "*b S"]) -> Float[Array, "*b S"]:
        """`values` with 0 in terminal states: nothing is earned, and nothing is seen, after an episode's end."""
        if self.terminal is None:
            return values
        return jnp.where(jnp.broadcast_to(self.terminal, values.shape), 0.0, values)

    @abc.abstractmethod
    def continuation(self, values: Float[Array, " S"]) -> AbstractPayoff:
        """E[V(s')|s, a] as a payoff with leading axis S."""

    @abc.abstractmethod
    def advance(self, distribution: Float[Array, " S"], policies: Sides[Float[Array, "..."]]) -> Float[Array, " S"]:
        """d_{t+1}(s') = Σ_s d_t(s) Σ_a π_l(a_l|s) π_e(a_e|s) P(s'|s,a); `policies` are those of one time, (S, A)."""

    @abc.abstractmethod
    def reset(self, key: PRNGKeyArray) -> Int[Array, ""]:
        """s_0 ~ P0."""

    @abc.abstractmethod
    def step(self, key: PRNGKeyArray, state: Int[Array, ""], actions: Sides[Int[Array, ""]]) -> Int[Array, ""]:
        """s' ~ P(·|s, a)."""

    def possible(
        self, states: Int[AnyArray, " n"], actions: Sides[Int[AnyArray, " n"]], following: Int[AnyArray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        """Whether P(s'|s, a) > 0, of n steps; True throughout for a kind of game that does not say."""
        return np.ones(len(states), bool)

    def observe(self, state: Int[Array, ""]) -> Sides[Int[Array, ""]]:
        """What each side sees of the state: here all of it."""
        return Sides(state, state)


class AbstractContinuousGame(eqx.Module, Generic[State]):
    """A two-sided game of T steps with real states and actions, whose dynamics can be differentiated.

    Each side's action is a vector in [−1, 1]^A, in units of the largest one; a step is deterministic, and all chance is
    in the initial state.
    """

    horizon: eqx.AbstractVar[int]

    def __repr__(self) -> str:
        sizes = self.action_size
        return f"{type(self).__name__}({sizes.learner} and {sizes.expert} actions, {self.horizon} steps)"

    @property
    @abc.abstractmethod
    def action_size(self) -> Sides[int]:
        """A_l and A_e."""

    @abc.abstractmethod
    def reset(self, key: PRNGKeyArray) -> State:
        """s_0 ~ P0."""

    @abc.abstractmethod
    def step(self, state: State, actions: Sides[Float[Array, "..."]]) -> State:
        """s' = P(s, a)."""

    @abc.abstractmethod
    def observe(self, state: State) -> Sides[Float[Array, "..."]]:
        """What each side sees of the state, a vector each; policies act on it."""
