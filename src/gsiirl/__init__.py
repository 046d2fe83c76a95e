"""General-sum interactive inverse reinforcement learning: learn an expert's reward by living with it."""

import importlib
from typing import Any

from gsiirl._version import __version__ as __version__
from gsiirl.errors import FitWarning as FitWarning
from gsiirl.errors import InputError as InputError

_MODULES = (
    "baselines",
    "equilibria",
    "evaluation",
    "games",
    "hypergradients",
    "irl",
    "rewards",
    "scenarios",
)
_MEMBERS = {
    "Bilevel": "gsiirl.bilevel",
    "GSIIRL": "gsiirl.fit",
    "Problem": "gsiirl.problem",
    "RespondingExpert": "gsiirl.expert",
    "RewardGSIIRL": "gsiirl.reward_learner",
    "SimulatedExpert": "gsiirl.expert",
    "load": "gsiirl.experiments.loading",
}

__all__ = ["FitWarning", "InputError", "__version__", *_MODULES, *_MEMBERS]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    # Imported when first used: the command line and the run folders do without JAX.
    if name in _MODULES:
        return importlib.import_module(f"gsiirl.{name}")
    if name in _MEMBERS:
        return getattr(importlib.import_module(_MEMBERS[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
