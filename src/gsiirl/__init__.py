"""General-sum interactive inverse reinforcement learning: learn an expert's reward by living with it."""

import importlib
from typing import TYPE_CHECKING, Any

from gsiirl._version import __version__ as __version__
from gsiirl.errors import FitWarning as FitWarning
from gsiirl.errors import InputError as InputError
from gsiirl.errors import NetworkWarning as NetworkWarning

if TYPE_CHECKING:
    from gsiirl import baselines as baselines
    from gsiirl import equilibria as equilibria
    from gsiirl import evaluation as evaluation
    from gsiirl import games as games
    from gsiirl import hypergradients as hypergradients
    from gsiirl import irl as irl
    from gsiirl import pettingzoo as pettingzoo
    from gsiirl import problems as problems
    from gsiirl import rewards as rewards
    from gsiirl import scenarios as scenarios
    from gsiirl.experiments.loading import load as load
    from gsiirl.experts.continuous_expert import ContinuousRespondingExpert as ContinuousRespondingExpert
    from gsiirl.experts.tabular_expert import RespondingExpert as RespondingExpert
    from gsiirl.experts.tabular_expert import SimulatedExpert as SimulatedExpert
    from gsiirl.front_door.fit import GSIIRL as GSIIRL
    from gsiirl.learners.bilevel import Bilevel as Bilevel
    from gsiirl.learners.reward_learner import RewardGSIIRL as RewardGSIIRL
    from gsiirl.problems.problem import Problem as Problem
    from gsiirl.types import Sides as Sides
    from gsiirl.types import Trajectories as Trajectories

_MODULES = (
    "baselines",
    "equilibria",
    "evaluation",
    "games",
    "hypergradients",
    "irl",
    "pettingzoo",
    "problems",
    "rewards",
    "scenarios",
)
_MEMBERS = {
    "Bilevel": "gsiirl.learners.bilevel",
    "ContinuousRespondingExpert": "gsiirl.experts.continuous_expert",
    "GSIIRL": "gsiirl.front_door.fit",
    "Problem": "gsiirl.problems.problem",
    "RespondingExpert": "gsiirl.experts.tabular_expert",
    "RewardGSIIRL": "gsiirl.learners.reward_learner",
    "Sides": "gsiirl.types",
    "SimulatedExpert": "gsiirl.experts.tabular_expert",
    "Trajectories": "gsiirl.types",
    "load": "gsiirl.experiments.loading",
}

__all__ = ["FitWarning", "InputError", "NetworkWarning", "__version__", *_MODULES, *_MEMBERS]  # pyright: ignore[reportUnsupportedDunderAll]


if not TYPE_CHECKING:  # a type checker would take every name for Any

    def __getattr__(name: str) -> Any:
        # Imported when first used: the command line and the run folders do without JAX.
        if name in _MODULES:
            return importlib.import_module(f"gsiirl.{name}")
        if name in _MEMBERS:
            return getattr(importlib.import_module(_MEMBERS[name]), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
