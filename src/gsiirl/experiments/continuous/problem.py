"""What the runs of continuous games are made of: the game, both rewards, what may be learned, and how to judge it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from jaxtyping import Array, PRNGKeyArray

from gsiirl.experiments.prepared_run import Record
from gsiirl.games.base import AbstractContinuousGame
from gsiirl.rewards.continuous import AbstractTransitionReward, LinearTransitionReward, TransitionReward
from gsiirl.types import Sides, Transition


@dataclass(frozen=True)
class ContinuousProblem:
    """One continuous experiment; the true expert reward goes to the expert and to what judges, and nowhere else."""

    description: dict[str, Any]
    """Content of `game.json`."""
    game: AbstractContinuousGame
    own_reward: TransitionReward
    """r_li."""
    dependent_value: TransitionReward
    """r_ld, to be read where the learner has been."""
    true_expert_reward: TransitionReward
    """r_e."""
    dependent_reward: LinearTransitionReward
    """r_ld^θ."""
    expert_reward: AbstractTransitionReward
    """r_e^θ."""
    anywhere: Callable[[PRNGKeyArray], Transition]
    """A random transition of the game, over which learned and true rewards are correlated."""
    judge_episodes: Callable[[Transition], Record]
    """Metrics of deployed episodes (axes d, T) besides returns."""
    judge_reward: Callable[[Array], Record]
    """Metrics of the learned θ_e besides correlations."""
    paths: Callable[[Transition], dict[str, Array]]
    """Columns of sample episodes (axes d, T), of shape [d, T + 1]."""
    reward_map: Callable[[Array], dict[str, Array]]
    """The expert's reward under θ_e beside the true one; empty for none."""

    @property
    def true_rewards(self) -> Sides[TransitionReward]:
        """r_ld + r_li and r_e."""
        return Sides(lambda seen: self.dependent_value(seen) + self.own_reward(seen), self.true_expert_reward)
