"""The paper's comparison: every algorithm on every game, for Table 1 and Figures 2-4."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from gsiirl.experiments.config import ExperimentConfig, load_config
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.plans.planned_run import PlannedRun
from gsiirl.experiments.security.config import SecurityConfig

ALGORITHMS = ("gsiirl", "paper", "ma-irl", "marl")
OF_FINITE_GAMES = ("lin2019",)
"""Algorithms of finite games alone; a quick comparison leaves them out."""


class ReproducedGame(NamedTuple):
    """A game on which all algorithms run; a quick comparison shortens its runs by `quick`, or leaves it out if None."""

    name: str
    kind: type[ExperimentConfig]
    fields: Mapping[str, Any]
    quick: Mapping[str, Any] | None


QUICK_CONTINUOUS = {
    "iterations": 10,
    "first_inner_steps": 100,
    "response_steps": 50,
    "model_response_steps": 20,
    "solver_steps": 30,
    "batch": 64,
    "training_steps": 200,
    "judging_steps": 200,
    "evaluation_episodes": 200,
    "maddpg_episodes": 40,
}

GAMES = (
    # The table's variant, r_ld = -r_e, and the one that the method is for.
    ReproducedGame("security-zero-sum", SecurityConfig, {"graph_seed": 0, "variant": "zero_sum"}, {"iterations": 5}),
    ReproducedGame("security-general-sum", SecurityConfig, {"graph_seed": 0, "variant": "general_sum"}, None),
    ReproducedGame("crossing", CrossingConfig, {}, QUICK_CONTINUOUS),
    ReproducedGame("deception", DeceptionConfig, {"variant": "mpe"}, {**QUICK_CONTINUOUS, "settling_steps": 200}),
)


def plan(out: Path, seeds: int, quick: bool, maddpg: bool) -> list[PlannedRun]:
    """Every run: algorithm a on game g in the folder g/a, and `marl` by the paper's solver in g/marl-maddpg."""
    return [
        PlannedRun(out / game.name / name, load_config(game.kind, {**fields, "seeds": seeds}))
        for game in GAMES
        if not quick or game.quick is not None
        for name, fields in _runs(game, quick, maddpg)
    ]


def _runs(game: ReproducedGame, quick: bool, maddpg: bool) -> Iterator[tuple[str, dict[str, Any]]]:
    fields = {**game.fields, **(game.quick or {})} if quick else dict(game.fields)
    finite = game.kind is SecurityConfig
    for algorithm in ALGORITHMS + (OF_FINITE_GAMES if finite and not quick else ()):
        yield algorithm, {**fields, "algorithm": algorithm}
    if maddpg and not finite:
        yield "marl-maddpg", {**fields, "algorithm": "marl", "solver": "maddpg"}
