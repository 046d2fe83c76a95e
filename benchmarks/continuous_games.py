"""The continuous games that benchmarks name, with the settings of their experiments."""

from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.experiments.crossing import problem as crossing
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception import problem as deception
from gsiirl.experiments.deception.config import DeceptionConfig

GAMES = ("deception", "separate_target", "crossing")
"""`deception` is its variant of mpe."""


def experiment_of(game: str) -> tuple[ContinuousConfig, ContinuousExperiment]:
    """The default configuration of one of `GAMES`, and its experiment."""
    if game == "crossing":
        config = CrossingConfig().resolved()
        return config, crossing.build(config)
    config = DeceptionConfig(variant="separate_target" if game == "separate_target" else "mpe").resolved()
    return config, deception.build(config)
