"""Forward models: from a game and rewards to a joint policy, and the yardstick that judges it."""

from gsiirl.equilibria.base import AbstractForwardModel as AbstractForwardModel
from gsiirl.equilibria.base import AbstractSolution as AbstractSolution
from gsiirl.equilibria.gap import nash_gap as nash_gap
from gsiirl.equilibria.gap import regularised_nash_gap as regularised_nash_gap
from gsiirl.equilibria.logit import Logit as Logit
from gsiirl.equilibria.logit import LogitSolution as LogitSolution
from gsiirl.equilibria.q_learning import QLearning as QLearning
from gsiirl.equilibria.q_learning import QLearningSolution as QLearningSolution
from gsiirl.equilibria.response import Response as Response
from gsiirl.equilibria.response import respond as respond
from gsiirl.equilibria.soft_joint import SoftJoint as SoftJoint
from gsiirl.equilibria.soft_joint import SoftJointSolution as SoftJointSolution
from gsiirl.equilibria.soft_joint import joint_occupancy as joint_occupancy
