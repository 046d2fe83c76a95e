"""An experiment's game, made ready to be played: of any settings, or of a run."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax

from gsiirl.errors import InputError
from gsiirl.experiments.config import EXPERIMENTS, ExperimentConfig, config_from_dict, load_config
from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.crossing.problem import build as build_crossing
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.deception.problem import build as build_deception
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.security.problem import SecurityProblem
from gsiirl.experiments.security.problem import build as build_security
from gsiirl.games.crossing import LARGEST_STEP
from gsiirl.games.deception import DAMPING, FORCE, TIME_STEP
from gsiirl.pettingzoo.playable import AbstractPlayable
from gsiirl.pettingzoo.playable_continuous import PlayableContinuous
from gsiirl.pettingzoo.playable_security import PlayableSecurity
from gsiirl.runs import RunFolder
from gsiirl.scenarios import read_network
from gsiirl.types import Sides

AGENTS = {
    SecurityConfig.experiment: Sides("defender", "attacker"),
    CrossingConfig.experiment: Sides("robot", "human"),
    DeceptionConfig.experiment: Sides("good_agents", "adversary"),
}
"""What the learner's side and the expert's are called as agents."""

AT_LEAST = 1.0
"""No position of the crossing or of deception is farther out than this at the start."""


@dataclass(frozen=True)
class Stage:
    """A game that can be played, and what it was made of."""

    config: ExperimentConfig
    experiment: SecurityProblem | ContinuousExperiment
    game: AbstractPlayable

    @property
    def agents(self) -> Sides[str]:
        """The names of both sides."""
        return AGENTS[self.config.experiment]


def stage(experiment: str, settings: Mapping[str, Any]) -> Stage:
    """The game of an experiment with these settings, the others at their defaults.

    Raises:
        InputError: there is no such experiment, or a setting is unknown or cannot be.
    """
    if experiment not in AGENTS:
        raise InputError("experiment", f"cannot be {experiment!r}", f"choose {' or '.join(AGENTS)}")
    return stage_of_config(load_config(EXPERIMENTS[experiment], settings).resolved(), None)


def stage_of_run(folder: RunFolder) -> Stage:
    """The game of a run, as it was then, wherever its network's file may be now.

    Raises:
        InputError: it is a run of another experiment, or damaged.
    """
    config = config_from_dict(folder.config, folder.path / "config.json")
    if config.experiment not in AGENTS:
        mend = f"give a run of {' or '.join(AGENTS)}"
        raise InputError(str(folder.path), f"is a run of {config.experiment}, which has no environment", mend)
    return stage_of_config(config, folder.path / "game.json")


def stage_of_config(config: ExperimentConfig, saved_game: Path | None) -> Stage:
    """The game of a resolved configuration; on the network of a run's `game.json`, where there is one."""
    with jax.enable_x64(config.double_precision):
        if isinstance(config, SecurityConfig):
            network = config.network() if saved_game is None else read_network(saved_game, config.variant)
            problem = build_security(config, network)
            return Stage(config, problem, PlayableSecurity.create(problem.game, problem.truth.rewards))
        if isinstance(config, CrossingConfig):
            crossing = build_crossing(config)
            return Stage(config, crossing, _continuous(crossing, AT_LEAST + LARGEST_STEP * config.horizon))
        assert isinstance(config, DeceptionConfig), "the caller has seen to it"
        deception = build_deception(config)
        # Observations are differences of two positions; nobody is ever faster than force and damping let it be.
        fastest = TIME_STEP * FORCE / DAMPING
        reach = AT_LEAST + TIME_STEP * fastest * config.horizon
        return Stage(config, deception, _continuous(deception, 2.0 * reach))


def _continuous(experiment: ContinuousExperiment, farthest: float) -> PlayableContinuous:
    return PlayableContinuous(experiment.problem.game, experiment.true_rewards, farthest)
