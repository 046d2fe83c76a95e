"""What every forward model gives: from a game and both rewards to a joint policy, with the quality of the solve."""

import abc

import equinox as eqx
from jaxtyping import Array, Bool, Float

from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Number, Policies, Sides


class AbstractSolution(eqx.Module):
    """A joint policy and how well its solver converged; the class says which solver made it.

    `residual` measures the equations of that solver; `converged` says whether it is small enough.
    """

    policies: eqx.AbstractVar[Policies]
    residual: eqx.AbstractVar[Float[Array, ""]]
    converged: eqx.AbstractVar[Bool[Array, ""]]


class AbstractForwardModel(eqx.Module):
    """A solver of tabular games: one function from rewards to a joint policy."""

    @abc.abstractmethod
    def solve(self, game: AbstractTabularGame, rewards: Sides[AbstractPayoff], discount: Number) -> AbstractSolution:
        """The joint policy of `game` under `rewards` (payoffs over all states)."""
