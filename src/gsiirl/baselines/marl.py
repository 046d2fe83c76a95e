"""MARL: the forward model given both true rewards; the horizontal line of the paper's figures."""

from gsiirl.equilibria.logit import Logit, LogitSolution
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides


def marl(
    game: AbstractTabularGame, true_rewards: Sides[AbstractPayoff], forward_model: Logit, discount: float
) -> LogitSolution:
    """The joint policy of two sides that know both true rewards."""
    return forward_model.solve(game, true_rewards, discount)
