"""Rewards: functions r(parameters, state, actions), kept apart from the dynamics."""

from gsiirl.rewards.linear import AbstractFeatures as AbstractFeatures
from gsiirl.rewards.linear import IndicatorFeatures as IndicatorFeatures
from gsiirl.rewards.linear import Linear as Linear
from gsiirl.rewards.linear import TabularFeatures as TabularFeatures
