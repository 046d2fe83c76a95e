"""MARL: the forward model given both true rewards; the horizontal line of the paper's figures."""

from gsiirl.equilibria.base import AbstractForwardModel, AbstractSolution
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides


def marl(
    game: AbstractTabularGame, true_rewards: Sides[AbstractPayoff], forward_model: AbstractForwardModel, discount: float
) -> AbstractSolution:
    """The joint policy of two sides that know both true rewards."""
    return forward_model.solve(game, true_rewards, discount)
