"""The experiments' problems by name, each with its simulated expert: what `gsiirl.problems` has."""

from collections.abc import Callable, Mapping
from os import fspath
from pathlib import Path
from typing import Any, TypeVar

import jax

from gsiirl.experiments.config import load_config
from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experts.continuous_expert import ContinuousRespondingExpert
from gsiirl.experts.tabular_expert import RespondingExpert, SimulatedExpert
from gsiirl.problems.continuous_problem import ContinuousProblem, single_precision
from gsiirl.problems.problem import Problem

Config = TypeVar("Config", CrossingConfig, DeceptionConfig)


def security(graph: str | Path | None = None, **settings: Any) -> tuple[Problem, RespondingExpert | SimulatedExpert]:
    """A defender's problem on an attack graph, and the attacker.

    `graph` is the name of a network (`gsiirl list`) or a file; none is a random one (`graph_seed=0`). `settings` are
    those of `gsiirl run security` that describe the game: `temperature=0.1`, `horizon=20`, `variant="zero_sum"`.

    Raises:
        InputError: there is no such network or setting.
    """
    from gsiirl.experiments.security.problem import build, told

    given = settings if graph is None else {"graph": fspath(graph), **settings}
    config = load_config(SecurityConfig, given).resolved()
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        built = build(config, config.network())
        return told(config, built), built.expert


def crossing(**settings: Any) -> tuple[ContinuousProblem, ContinuousRespondingExpert]:
    """A robot's problem in the plane, and the human whose way it crosses; `settings` as of `gsiirl run crossing`.

    Raises:
        InputError: there is no such setting.
    """
    from gsiirl.experiments.crossing.problem import build

    return _continuous(CrossingConfig, build, settings)


def deception(**settings: Any) -> tuple[ContinuousProblem, ContinuousRespondingExpert]:
    """Two agents' problem of hiding their target, and the adversary; `settings` as of `gsiirl run deception`.

    Raises:
        InputError: there is no such setting.
    """
    from gsiirl.experiments.deception.problem import build

    return _continuous(DeceptionConfig, build, settings)


def _continuous(
    kind: type[Config], build: Callable[[Config], ContinuousExperiment], settings: Mapping[str, Any]
) -> tuple[ContinuousProblem, ContinuousRespondingExpert]:
    from gsiirl.experiments.continuous.run import expert_of

    with single_precision():
        config = load_config(kind, settings).resolved()
        experiment = build(config)
        return experiment.problem, expert_of(config, experiment)
