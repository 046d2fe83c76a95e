"""One recorded trajectory of an attack graph."""

from dataclasses import dataclass

import polars

from gsiirl.errors import InputError
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.security.recorded_graph import OUTSIDE, RecordedGraph
from gsiirl.runs.files.damage import START_AGAIN

WORD = 62
"""Nodes in one column of the states."""


@dataclass(frozen=True)
class PathStep:
    """The two actions of a step and their outcome."""

    attack: str
    block: str
    outcome: str
    """`taken`, `blocked`, `failed`, `wasted` (the attack could not succeed), `idle` or `unknown` (not recorded)."""
    compromised: frozenset[int]
    """Nodes compromised after the step; before it, where the state after it is not recorded."""
    fallen: frozenset[int]
    """Nodes that fell in this step."""


@dataclass(frozen=True)
class SamplePath:
    """A trajectory and its place among the recorded ones."""

    seed: int
    trajectory: int
    recorded: int
    """Number of trajectories it was picked from."""
    steps: list[PathStep]


def pick_sample_path(graph: RecordedGraph, run: ReportedRun) -> SamplePath | None:
    """The recorded trajectory in which most nodes fall, of equals the first; None where none was recorded.

    Raises:
        InputError: the table of the paths lacks a column.
    """
    trajectories, count = run.trajectories(("expert_action", "learner_action", "state")), len(graph.edges)
    if not trajectories:
        return None
    states = [name for name in trajectories[0].columns if name.startswith("state")]
    limits = {"expert_action": count + 1, "learner_action": count + 1}
    limits |= {name: 1 << min(len(graph.nodes), WORD) for name in states}
    for name, limit in limits.items():
        if not all(
            table[name].dtype == polars.Int64 and table[name].is_between(0, limit - 1).all() for table in trajectories
        ):
            raise InputError(str(run.path / "paths.parquet"), f"is damaged: {name} is none of the game", START_AGAIN)
    chosen = max(trajectories, key=lambda table: _states(table)[-1].bit_count())
    states = _states(chosen)
    rows = zip(chosen["expert_action"], chosen["learner_action"], states, [*states[1:], None], strict=True)
    steps = [_step(graph, *row) for row in rows]
    return SamplePath(int(chosen["seed"][0]), int(chosen["trajectory"][0]), len(trajectories), steps)


def _states(table: polars.DataFrame) -> list[int]:
    """The bitmasks of a trajectory; a large network's are in several columns, `WORD` nodes in each."""
    names = ["state", *(name for name in table.columns if name.startswith("state_"))]
    columns = sorted(names, key=lambda name: int(name.removeprefix("state").removeprefix("_") or 0))
    return [sum(int(word) << WORD * place for place, word in enumerate(row)) for row in table.select(columns).rows()]


def _step(graph: RecordedGraph, attack: int, block: int, state: int, following: int | None) -> PathStep:
    return PathStep(
        attack=graph.edge_name(attack),
        block=graph.edge_name(block),
        outcome=_outcome(graph, attack, block, state, following),
        compromised=_members(state if following is None else following),
        fallen=_members(0 if following is None else following & ~state),
    )


def _outcome(graph: RecordedGraph, attack: int, block: int, state: int, following: int | None) -> str:
    if attack == len(graph.edges):
        return "idle"
    source, target = graph.edges[attack]
    if (source != OUTSIDE and not state >> source & 1) or state >> target & 1:
        return "wasted"
    if attack == block:
        return "blocked"
    if following is None:
        return "unknown"
    return "taken" if following != state else "failed"


def _members(state: int) -> frozenset[int]:
    """The nodes whose bits are set."""
    return frozenset(node for node in range(state.bit_length()) if state >> node & 1)
