"""Games: dynamics only; a game never returns a reward."""

from gsiirl.games.attack_graph import AttackGraph as AttackGraph
from gsiirl.games.base import AbstractTabularGame as AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff as AbstractPayoff
from gsiirl.games.payoff import DensePayoff as DensePayoff
from gsiirl.games.payoff import MatchingPayoff as MatchingPayoff
from gsiirl.games.rollout import rollout as rollout
from gsiirl.games.tabular import TabularGame as TabularGame
