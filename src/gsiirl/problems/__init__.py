"""What a learner is told: a game, its own reward, and what it may find out of the rest.

`security(...)`, `crossing(...)` and `deception(...)` are the problems of the experiments, each with its expert.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gsiirl.experiments.named import crossing as crossing
    from gsiirl.experiments.named import deception as deception
    from gsiirl.experiments.named import security as security

_NAMED = ("crossing", "deception", "security")


if not TYPE_CHECKING:  # a type checker would take every name for Any

    def __getattr__(name: str) -> Any:
        # They are made by the experiments, which are built on this folder.
        if name in _NAMED:
            return getattr(importlib.import_module("gsiirl.experiments.named"), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(_NAMED)
