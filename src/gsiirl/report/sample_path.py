"""One recorded trajectory of an attack graph, told step by step."""

from dataclasses import dataclass

import polars

from gsiirl.report.attack_graph import AttackGraph
from gsiirl.report.run import ReportedRun


@dataclass(frozen=True)
class Step:
    """One step: what was tried, and what came of it."""

    attack: str
    block: str
    outcome: str
    """`taken`, `blocked`, `failed`, `wasted` (the attack could not succeed), `idle` or `unknown` (not recorded)."""
    compromised: frozenset[int]
    """Nodes compromised after the step; before it, where what came after is not recorded."""
    fallen: frozenset[int]
    """Those of them that fell in this step."""


@dataclass(frozen=True)
class SamplePath:
    """A trajectory and where it comes from."""

    seed: int
    trajectory: int
    recorded: int
    """Number of trajectories it was picked from."""
    steps: list[Step]


def pick_sample_path(graph: AttackGraph, run: ReportedRun) -> SamplePath | None:
    """The recorded trajectory in which most nodes fall (the first of those), or None where none was recorded."""
    if run.paths is None:
        return None
    kept = run.paths.filter(polars.col("seed").is_in(run.kept_seeds)).sort("seed", "trajectory", "step")
    trajectories = kept.partition_by("seed", "trajectory", maintain_order=True)
    if not trajectories:
        return None
    chosen = max(trajectories, key=lambda table: int(table["state"][-1]).bit_count())
    states = chosen["state"].to_list()
    steps = [
        Step(
            attack=graph.edge_name(attack),
            block=graph.edge_name(block),
            outcome=_outcome(graph, attack, block, state, following),
            compromised=_members(state if following is None else following),
            fallen=_members(0 if following is None else following & ~state),
        )
        for attack, block, state, following in zip(
            chosen["expert_action"], chosen["learner_action"], states, [*states[1:], None], strict=True
        )
    ]
    return SamplePath(int(chosen["seed"][0]), int(chosen["trajectory"][0]), len(trajectories), steps)


def _outcome(graph: AttackGraph, attack: int, block: int, state: int, following: int | None) -> str:
    if attack == len(graph.edges):
        return "idle"
    source, target = graph.edges[attack]
    if (source is not None and not state >> source & 1) or state >> target & 1:
        return "wasted"
    if attack == block:
        return "blocked"
    if following is None:
        return "unknown"
    return "taken" if following != state else "failed"


def _members(state: int) -> frozenset[int]:
    return frozenset(node for node in range(state.bit_length()) if state >> node & 1)
