"""The experiments' problems by name, each with its simulated expert: what `gsiirl.problems` has."""

from os import fspath
from pathlib import Path
from typing import Any, TypeVar

import jax

from gsiirl.experiments.config import load_config
from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experts.continuous_expert import ContinuousRespondingExpert
from gsiirl.experts.tabular_expert import RespondingExpert, SimulatedExpert
from gsiirl.problems.continuous_problem import ContinuousProblem, single_precision
from gsiirl.problems.problem import Problem

Continuous = TypeVar("Continuous", bound=ContinuousConfig)


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

    with single_precision():
        config = load_config(CrossingConfig, settings).resolved()
        return _continuous(config, build(config))


def deception(**settings: Any) -> tuple[ContinuousProblem, ContinuousRespondingExpert]:
    """Two agents' problem of hiding their target, and the adversary; `settings` as of `gsiirl run deception`.

    Raises:
        InputError: there is no such setting.
    """
    from gsiirl.experiments.deception.problem import build

    with single_precision():
        config = load_config(DeceptionConfig, settings).resolved()
        return _continuous(config, build(config))


def _continuous(
    config: ContinuousConfig, experiment: ContinuousExperiment
) -> tuple[ContinuousProblem, ContinuousRespondingExpert]:
    from gsiirl.experiments.continuous.run import expert_of

    return experiment.problem, expert_of(config, experiment)
