"""A game as an environment needs it: what one step is and pays, and what both sides see, as functions of one state."""

import abc

import equinox as eqx
from jaxtyping import Array, Float, PRNGKeyArray, PyTree

from gsiirl.types import Sides

Bounds = tuple[list[float], list[float]]
"""The least and the greatest that each entry of an observation can be."""


class AbstractPlayable(eqx.Module):
    """A game with both true rewards, one step at a time.

    What a side observes is a vector of 32-bit numbers, whose last entry is the share of the episode that is over, t/T.
    """

    @property
    @abc.abstractmethod
    def horizon(self) -> int:
        """T."""

    @property
    @abc.abstractmethod
    def action_number(self) -> Sides[int] | None:
        """How many actions each side chooses from; None where actions are vectors."""

    @property
    @abc.abstractmethod
    def action_size(self) -> Sides[int] | None:
        """How long each side's action is, a vector in [−1, 1]^A; None where actions are numbered."""

    @property
    @abc.abstractmethod
    def bounds(self) -> Sides[Bounds]:
        """Of what each side observes."""

    @abc.abstractmethod
    def reset(self, key: PRNGKeyArray) -> PyTree:
        """s_0 ~ P0."""

    @abc.abstractmethod
    def step(self, key: PRNGKeyArray, state: PyTree, actions: Sides[Array]) -> tuple[PyTree, Sides[Float[Array, ""]]]:
        """s' ~ P(·|s, a), and what the step pays both sides."""

    @abc.abstractmethod
    def observe(self, state: PyTree, time: Float[Array, ""]) -> Sides[Float[Array, " o"]]:
        """What each side sees of the state, then t/T."""
