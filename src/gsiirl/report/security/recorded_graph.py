"""The attack graph in the `game.json` of a run."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.runs.files.damage import refuse_damaged

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

    @classmethod
    def read(cls, game: dict[str, Any], run: Path) -> "RecordedGraph":
        """The graph in `game`, the content of the `game.json` of the folder `run`.

        Raises:
            InputError: the description is damaged.
        """
        with refuse_damaged(run / "game.json"):
            nodes, edges, truth = game["nodes"], game["edges"], game["truth"]
            index = {str(node["name"]): position for position, node in enumerate(nodes)}
            features = len(nodes) + len(edges)
            expert, dependent = (np.array(truth[f"{side}_reward"], dtype=float) for side in ("expert", "dependent"))
            # The class of the dependent reward may have more features, after those of nodes and edges.
            if expert.shape != (features,) or dependent.size < features:
                raise ValueError("truth does not hold one weight a node and edge")
            return cls(
                nodes=[str(node["name"]) for node in nodes],
                footholds=[bool(node["foothold"]) for node in nodes],
                edges=[
                    (OUTSIDE if edge["source"] is None else index[edge["source"]], index[edge["target"]])
                    for edge in edges
                ],
                success_probability=[float(edge["success_probability"]) for edge in edges],
                expert_truth=expert,
                dependent_truth=dependent[:features],
                expert_no_op=bool(game.get("no_op", {}).get("expert", False)),
            )

    def edge_name(self, edge: int) -> str:
        """An edge as `source → target`; the index after the last edge is the no-op."""
        if edge == len(self.edges):
            return "nothing"
        source, target = self.edges[edge]
        return f"{'outside' if source == OUTSIDE else self.nodes[source]} \N{RIGHTWARDS ARROW} {self.nodes[target]}"
