"""The attack graph in the `game.json` of a run."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import networkx
import numpy as np

from gsiirl.runs.files.damage import START_AGAIN, refuse_damaged
from gsiirl.runs.files.json_file import as_typed

OUTSIDE = -1
"""Source of an attack that comes from outside the graph."""


@dataclass(frozen=True)
class RecordedGraph:
    """N nodes and E edges, with the true reward weights."""

    nodes: list[str]
    footholds: list[bool]
    edges: list[tuple[int, int]]
    """Source and target as node indices; a source may be `OUTSIDE`."""
    success_probability: list[float]
    expert_truth: np.ndarray
    """True weights of the expert's reward, [N + E]: values of the nodes, then costs of the edges."""
    dependent_truth: np.ndarray
    """True weights of the learner's dependent reward, [N + E]: losses of the nodes, then the attacker's costs."""
    expert_no_op: bool
    """Whether the attacker may attack nothing."""
    horizon: int | None = None
    """Steps of an episode; None where it is not recorded."""

    @classmethod
    def read(cls, game: dict[str, Any], run: Path) -> "RecordedGraph":
        """The graph in `game`, the content of the `game.json` of the folder `run`.

        Raises:
            InputError: the description is damaged.
        """
        path = run / "game.json"
        described = as_typed(_Described, game, path, START_AGAIN)
        nodes, edges, truth = described.nodes, described.edges, described.truth
        index = {node.name: position for position, node in enumerate(nodes)}
        features = len(nodes) + len(edges)
        with refuse_damaged(path):
            # The class of the dependent reward may have more features, after those of nodes and edges.
            if len(truth.expert_reward) != features or len(truth.dependent_reward) < features:
                raise ValueError("truth does not hold one weight a node and edge")
            return cls(
                nodes=[node.name for node in nodes],
                footholds=[node.foothold for node in nodes],
                edges=[(OUTSIDE if edge.source is None else index[edge.source], index[edge.target]) for edge in edges],
                success_probability=[edge.success_probability for edge in edges],
                expert_truth=np.array(truth.expert_reward, dtype=float),
                dependent_truth=np.array(truth.dependent_reward[:features], dtype=float),
                expert_no_op=described.no_op.get("expert", False),
                horizon=described.horizon,
            )

    @cached_property
    def distance(self) -> dict[int, int]:
        """Successful attacks that it takes to hold a node, 0 for a foothold; nodes that none reaches are absent."""
        start = OUTSIDE - 1
        network = networkx.DiGraph(self.edges)
        network.add_edges_from((start, node) for node, foothold in enumerate(self.footholds) if foothold)
        network.add_edge(start, OUTSIDE)
        steps = networkx.single_source_shortest_path_length(network, start)
        return {node: length - 1 for node, length in steps.items() if node >= 0}

    def can_fall(self, node: int) -> bool:
        """Whether a node is none of the footholds and can be reached in an episode."""
        return 0 < self.distance.get(node, 0) <= (self.horizon or len(self.nodes))

    def can_be_attacked(self, edge: int) -> bool:
        """Whether an attack along an edge can ever succeed in an episode."""
        source, target = self.edges[edge]
        held_after = 0 if source == OUTSIDE else self.distance.get(source)
        return held_after is not None and held_after < (self.horizon or len(self.nodes)) and not self.footholds[target]

    def edge_name(self, edge: int) -> str:
        """An edge as `source → target`; the index after the last edge is the no-op."""
        if edge == len(self.edges):
            return "nothing"
        source, target = self.edges[edge]
        return f"{'outside' if source == OUTSIDE else self.nodes[source]} \N{RIGHTWARDS ARROW} {self.nodes[target]}"


@dataclass(frozen=True)
class _Node:
    name: str
    foothold: bool


@dataclass(frozen=True)
class _Edge:
    source: str | None
    target: str
    success_probability: float


@dataclass(frozen=True)
class _Truth:
    expert_reward: list[float]
    dependent_reward: list[float]


@dataclass(frozen=True)
class _Described:
    """The part of `game.json` that is drawn."""

    nodes: list[_Node]
    edges: list[_Edge]
    truth: _Truth
    no_op: dict[str, bool] = field(default_factory=dict[str, bool])
    horizon: int | None = None

    def __post_init__(self) -> None:
        if not self.nodes or len({node.name for node in self.nodes}) < len(self.nodes):
            raise ValueError("nodes are none, or two have one name")
