"""The lower level: learning the expert's reward from what it did."""

from gsiirl.irl.dependent_reward import DependentValue as DependentValue
from gsiirl.irl.dependent_reward import LeastSquares as LeastSquares
from gsiirl.irl.expectations import expected_return as expected_return
from gsiirl.irl.expectations import reward_gradient_expectation as reward_gradient_expectation
from gsiirl.irl.expectations import sampled_reward_gradient as sampled_reward_gradient
from gsiirl.irl.expectations import state_distributions as state_distributions
from gsiirl.irl.maximum_likelihood import MaximumLikelihood as MaximumLikelihood
from gsiirl.irl.memory import Memory as Memory
from gsiirl.irl.memory import Played as Played
