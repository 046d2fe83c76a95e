"""What a game is: dynamics alone. Rewards live outside (see `gsiirl.rewards`)."""

import abc
from typing import Generic, TypeVar

import equinox as eqx
from jaxtyping import Array, Float, Int, PRNGKeyArray

from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides

State = TypeVar("State")


class AbstractTabularGame(eqx.Module):
    """A two-sided finite-horizon Markov game with S states and A_l, A_e actions.

    A subclass says how values flow back (`continuation`), how mass flows forward (`advance`, its transpose), and how
    one step is sampled (`step`).
    """

    horizon: eqx.AbstractVar[int]
    initial: eqx.AbstractVar[Float[Array, " S"]]

    @property
    @abc.abstractmethod
    def number_of_actions(self) -> Sides[int]:
        """A_l and A_e."""

    @property
    def number_of_states(self) -> int:
        """S."""
        return self.initial.shape[0]

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

    def observe(self, state: Int[Array, ""]) -> Sides[Int[Array, ""]]:
        """What each side sees of the state: here all of it."""
        return Sides(state, state)


class AbstractContinuousGame(eqx.Module, Generic[State]):
    """A two-sided game of T steps with real states and actions, whose dynamics can be differentiated.

    Each side's action is a vector in [−1, 1]^A, in units of the largest one; a step is deterministic, and all chance is
    in the initial state.
    """

    horizon: eqx.AbstractVar[int]

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
