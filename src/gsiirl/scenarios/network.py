"""The attack network: hosts, attack edges, and what they are worth to either side."""

import math
import operator
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from gsiirl.errors import InputError, printable

Variant = Literal["general_sum", "zero_sum"]

MAXIMUM_NODES = 1000
"""More than a game has that fits a computer's memory; how many a run can have depends on its states and edges."""

OUTSIDE = -1
"""Source index of an entry edge."""


@dataclass(frozen=True, eq=False)
class AttackNetwork:
    """A network of N nodes and E attack edges i -> j, checked when it is made; its arrays are read-only.

    In the game of it, the attack on i -> j succeeds with the edge's probability if i is compromised (or the edge is an
    entry edge, from outside), j is not, and the defender does not block that edge in the same step.

    Raises:
        InputError: when a field is malformed, or when no attack could ever be made.
    """

    name: str
    node_names: tuple[str, ...]
    value: np.ndarray
    """(N,): the attacker's gain when the node is newly compromised."""
    criticality: np.ndarray
    """(N,): the defender's loss when the node is newly compromised; equal to `value` when `zero_sum`."""
    edge_source: np.ndarray
    """(E,): node index, or -1 for an entry edge."""
    edge_target: np.ndarray
    """(E,): node index."""
    success_probability: np.ndarray
    """(E,) in (0, 1]."""
    attack_cost: np.ndarray
    """(E,) >= 0: what the attacker pays for a try."""
    block_cost: np.ndarray
    """(E,) >= 0: what the defender pays for a step of blocking."""
    footholds: tuple[int, ...] = ()
    """Nodes compromised at the start."""
    variant: Variant = "general_sum"
    """`zero_sum`: the defender's dependent reward is the negative of the attacker's, attack costs included."""

    def __post_init__(self) -> None:
        if self.variant not in get_args(Variant):
            raise InputError("variant", f"{self.variant!r} is unknown", f"give one of {', '.join(get_args(Variant))}")
        self._set("node_names", tuple(self.node_names))
        self._check_nodes()
        self._check_edges()
        self._set("footholds", tuple(sorted({operator.index(node) for node in self.footholds})))
        self._check_start()
        if self.variant == "zero_sum" and not np.array_equal(self.criticality, self.value):
            raise InputError(
                "criticality", "differs from value in a zero_sum network", "make them equal, or use general_sum"
            )

    def _set(self, field: str, content: object) -> None:
        object.__setattr__(self, field, content)

    def _check_nodes(self) -> None:
        count = len(self.node_names)
        if not 1 <= count <= MAXIMUM_NODES:
            raise InputError("nodes", f"there are {count} nodes", f"give 1 to {MAXIMUM_NODES} nodes")
        seen: set[str] = set()
        for name in self.node_names:
            if name in seen:
                raise InputError("nodes", f"node '{shown(name)}' is there twice", "give every node a name of its own")
            seen.add(name)
            if name == "outside":
                raise InputError(
                    "nodes", "the name 'outside' stands for where entry edges come from", "rename this node"
                )
        labels = [f"node '{shown(name)}'" for name in self.node_names]
        for field in ("value", "criticality"):
            self._set_numbers(field, labels)

    def _check_edges(self) -> None:
        for field in ("edge_source", "edge_target"):
            content = np.array(getattr(self, field))
            if content.ndim != 1 or content.size == 0:
                raise InputError(field, "there is no list of edges here", "give at least one edge")
            if content.dtype.kind not in "iu":
                raise InputError(field, "holds something else than node indices", "give whole numbers")
            self._set(field, _read_only(content.astype(np.int64)))
        if self.edge_source.shape != self.edge_target.shape:
            sizes = f"{self.edge_source.size} sources for {self.edge_target.size} targets"
            raise InputError("edge_target", f"there are {sizes}", "give one of each for every edge")
        for field, lowest in (("edge_source", OUTSIDE), ("edge_target", 0)):
            for edge, node in enumerate(getattr(self, field).tolist()):
                if not lowest <= node < len(self.node_names):
                    raise InputError(
                        field, f"edge {edge} names node {node}", f"give {lowest} to {len(self.node_names) - 1}"
                    )
        labels = [f"edge '{shown(name, 120)}'" for name in self.edge_names]
        pairs: set[tuple[int, int]] = set()
        for label, source, target in zip(labels, self.edge_source.tolist(), self.edge_target.tolist(), strict=True):
            if source == target:
                raise InputError("edges", f"{label} leads from a node to itself", "remove it")
            if (source, target) in pairs:
                raise InputError("edges", f"{label} is there twice", "keep one of the two")
            pairs.add((source, target))
        for field in ("success_probability", "attack_cost", "block_cost"):
            self._set_numbers(field, labels)

    def _check_start(self) -> None:
        count = len(self.node_names)
        for node in self.footholds:
            if not 0 <= node < count:
                raise InputError("foothold", f"there is no node {node}", f"give indices from 0 to {count - 1}")
        compromised = [OUTSIDE, *self.footholds]
        if not np.any(np.isin(self.edge_source, compromised) & ~np.isin(self.edge_target, compromised)):
            raise InputError(
                "foothold",
                "nothing can ever be attacked: no edge leads from outside or from a foothold to another node",
                "mark a node that has outgoing edges as a foothold, or add an entry edge from outside",
            )

    def _set_numbers(self, field: str, labels: list[str]) -> None:
        try:
            content = np.array(getattr(self, field), dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise InputError(field, "holds something else than numbers", "give numbers") from None
        if content.shape != (len(labels),):
            raise InputError(field, f"has shape {content.shape}", f"give {len(labels)} numbers, one for each")
        for label, number in zip(labels, content.tolist(), strict=True):
            check_number(field, label, number)
        self._set(field, _read_only(content))

    @property
    def edge_names(self) -> tuple[str, ...]:
        """E names, "source -> target"; the source of an entry edge is "outside"."""
        return tuple(
            f"{'outside' if source == OUTSIDE else self.node_names[source]} -> {self.node_names[target]}"
            for source, target in zip(self.edge_source.tolist(), self.edge_target.tolist(), strict=True)
        )

    @property
    def unit(self) -> float:
        """What the attacker's rewards are counted in: the largest absolute value or attack cost; 1 where all are 0."""
        return float(max(abs(self.value).max(), self.attack_cost.max())) or 1.0

    @property
    def largest_weight(self) -> float:
        """The largest absolute value, loss or attack cost; 1 where all are 0."""
        return float(max(abs(self.value).max(), abs(self.criticality).max(), self.attack_cost.max())) or 1.0

    def with_variant(self, variant: Variant) -> "AttackNetwork":
        """The same network in another variant; `zero_sum` replaces the criticality by the value."""
        criticality = self.value if variant == "zero_sum" else self.criticality
        return replace(self, variant=variant, criticality=criticality)

    def to_json_dict(self) -> Mapping[str, Any]:
        """What `game.json` holds of the network; `read_network` reads it back."""
        return {
            "kind": "attack_graph",
            "name": self.name,
            "variant": self.variant,
            "nodes": [
                {
                    "name": name,
                    "value": float(self.value[node]),
                    "criticality": float(self.criticality[node]),
                    "foothold": node in self.footholds,
                }
                for node, name in enumerate(self.node_names)
            ],
            "edges": [
                {
                    "source": None if source == OUTSIDE else self.node_names[source],
                    "target": self.node_names[self.edge_target[edge]],
                    "success_probability": float(self.success_probability[edge]),
                    "attack_cost": float(self.attack_cost[edge]),
                    "block_cost": float(self.block_cost[edge]),
                }
                for edge, source in enumerate(self.edge_source.tolist())
            ],
        }


def check_number(field: str, label: str, number: float) -> None:
    """Refuse a number that the field of a network cannot have; `label` says whose it is."""
    if not math.isfinite(number):
        shown_number = "NaN" if math.isnan(number) else "an infinite number"
        raise InputError(field, f"{label} has {shown_number}", "give a finite number")
    if field == "success_probability" and not 0 < number <= 1:
        raise InputError(field, f"{label} has {number:g}", "give a number above 0 and at most 1")
    if field in ("attack_cost", "block_cost") and number < 0:
        raise InputError(field, f"{label} has {number:g}", "give 0 or more: a cost is paid, not earned")


def shown(text: str, limit: int = 60) -> str:
    """A text of the user's as messages show it: short, and without characters that a terminal would act on."""
    if len(text) > limit:
        text = f"{text[: limit - 20]}...{text[-17:]}"
    return printable(text)


def _read_only(array: np.ndarray) -> np.ndarray:
    array.setflags(write=False)
    return array
