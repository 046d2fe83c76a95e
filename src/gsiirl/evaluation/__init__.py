"""Evaluation: returns under the true rewards, and how right the learned rewards are."""

from gsiirl.evaluation.reward_similarity import RewardSimilarity as RewardSimilarity
from gsiirl.evaluation.truth import Truth as Truth
