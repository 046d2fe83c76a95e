"""Games: dynamics only; a game never returns a reward."""

from gsiirl.games.attack_graph import AttackGraph as AttackGraph
from gsiirl.games.base import AbstractContinuousGame as AbstractContinuousGame
from gsiirl.games.base import AbstractTabularGame as AbstractTabularGame
from gsiirl.games.crossing import Crossing as Crossing
from gsiirl.games.crossing import CrossingState as CrossingState
from gsiirl.games.deception import Deception as Deception
from gsiirl.games.deception import DeceptionState as DeceptionState
from gsiirl.games.payoff import AbstractPayoff as AbstractPayoff
from gsiirl.games.payoff import DensePayoff as DensePayoff
from gsiirl.games.payoff import MatchingPayoff as MatchingPayoff
from gsiirl.games.rollout import Policy as Policy
from gsiirl.games.rollout import play as play
from gsiirl.games.rollout import rollout as rollout
from gsiirl.games.tabular import TabularGame as TabularGame
