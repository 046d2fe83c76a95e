"""What the runs of continuous games are made of: what the learner is told, the truth, and how to judge by it."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

from jaxtyping import Array, PRNGKeyArray

from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.prepared_run import Record
from gsiirl.front_door.continuous_fit import ContinuousGSIIRL
from gsiirl.problems.continuous_problem import ContinuousProblem
from gsiirl.rewards.continuous import TransitionReward
from gsiirl.types import Sides, Transition


@dataclass(frozen=True)
class ContinuousExperiment:
    """One continuous experiment; the true expert reward goes to the expert and to what judges, and nowhere else."""

    description: dict[str, Any]
    """Content of `game.json`."""
    problem: ContinuousProblem
    """What the learner is told."""
    true_expert_reward: TransitionReward
    """r_e."""
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
        return self.problem.true_rewards(self.true_expert_reward)


def front_door_of(config: ContinuousConfig, problem: ContinuousProblem) -> ContinuousGSIIRL:
    """`GSIIRL(problem)` with the settings of a configuration."""
    settings = {each.name: getattr(config, each.name) for each in fields(ContinuousGSIIRL) if each.kw_only}
    return ContinuousGSIIRL(problem, **settings)
