"""Baselines: what is known without interacting, or with both rewards given."""

from gsiirl.baselines.lin2019 import Lin2019 as Lin2019
from gsiirl.baselines.ma_irl import MAIRL as MAIRL
from gsiirl.baselines.maddpg import Maddpg as Maddpg
from gsiirl.baselines.maddpg import MaddpgState as MaddpgState
from gsiirl.baselines.marl import marl as marl
