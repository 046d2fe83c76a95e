"""The attack graph of a `game.json`, with the true reward weights."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.errors import InputError


@dataclass(frozen=True)
class AttackGraph:
    """N nodes and E edges; an edge's source is None where the attack comes from outside."""

    nodes: list[str]
    footholds: list[bool]
    edges: list[tuple[int | None, int]]
    """Source and target as node indices."""
    success_probability: list[float]
    expert_truth: np.ndarray
    """True weights of the expert's reward, [N + E]: values of the nodes, then costs of the edges."""
    dependent_truth: np.ndarray
    """True weights of the learner's dependent reward, [N + E]: losses of the nodes, then the attacker's costs."""
    expert_no_op: bool
    """Whether the attacker may attack nothing."""

    @classmethod
    def read(cls, game: dict[str, Any], run: Path) -> "AttackGraph":
        """The graph in `game.json`.

        Raises:
            InputError: the description is damaged; `run` names it.
        """
        try:
            names = [str(node["name"]) for node in game["nodes"]]
            index = {name: position for position, name in enumerate(names)}
            truth = {name: np.array(game["truth"][name], dtype=float) for name in ("expert_reward", "dependent_reward")}
            graph = cls(
                nodes=names,
                footholds=[bool(node["foothold"]) for node in game["nodes"]],
                edges=[
                    (None if edge["source"] is None else index[edge["source"]], index[edge["target"]])
                    for edge in game["edges"]
                ],
                success_probability=[float(edge["success_probability"]) for edge in game["edges"]],
                expert_truth=truth["expert_reward"],
                dependent_truth=truth["dependent_reward"][: len(names) + len(game["edges"])],
                expert_no_op=bool(game.get("no_op", {}).get("expert", False)),
            )
            features = len(graph.nodes) + len(graph.edges)
            # The dependent reward's class may have more features, after those of nodes and edges.
            if graph.expert_truth.shape != (features,) or graph.dependent_truth.size < features:
                raise ValueError("truth does not hold one weight a node and edge")
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                str(run / "game.json"), f"is damaged ({error!r})", "start the run again in another folder"
            ) from error
        return graph

    def edge_name(self, edge: int) -> str:
        """An edge as `source -> target`; the index after the last is the no-op."""
        if edge == len(self.edges):
            return "nothing"
        source, target = self.edges[edge]
        return f"{'outside' if source is None else self.nodes[source]} \N{RIGHTWARDS ARROW} {self.nodes[target]}"
