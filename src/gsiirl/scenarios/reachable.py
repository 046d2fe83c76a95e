"""The states that an attack network's game can reach: sets of compromised nodes, as bitmasks."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

from gsiirl.scenarios.network import OUTSIDE, AttackNetwork

WORD = 62
"""Nodes whose bits are held together in 64-bit arithmetic; a larger network's masks are Python's own integers."""
BLOCK = 2**18
"""Attacks that are looked at together."""


class TooManyStatesError(Exception):
    """More states can be reached than were to be counted."""


class AttackMoves:
    """What each edge i -> j does to a state: it needs i's bit, and sets j's."""

    def __init__(self, network: AttackNetwork) -> None:
        self._kind = np.int64 if len(network.node_names) <= WORD else object
        # Entry edges start outside: their source counts as compromised in every state.
        self.source_bit = self.masks(0 if node < 0 else 1 << node for node in network.edge_source.tolist())
        self.target_bit = self.masks(1 << node for node in network.edge_target.tolist())

    def masks(self, bitmasks: Iterable[int]) -> np.ndarray:
        """Bitmasks as an array that these moves can be applied to."""
        return np.array(list(bitmasks), dtype=self._kind)

    def usable(self, masks: np.ndarray) -> np.ndarray:
        """Whether an edge can be attacked in a state (S, E)."""
        held = (masks[:, None] & self.source_bit) == self.source_bit
        return (held & ((masks[:, None] & self.target_bit) == 0)).astype(bool)

    def following(self, masks: np.ndarray) -> np.ndarray:
        """The states, each once and in order, that one success leads to from any of `masks`."""
        return np.unique((masks[:, None] | self.target_bit)[self.usable(masks)])


def starting_state(network: AttackNetwork) -> int:
    """The bitmask of the footholds."""
    return sum(1 << node for node in network.footholds)


def reachable_states(network: AttackNetwork, starts: Sequence[int], most: float = math.inf) -> np.ndarray:
    """Bitmasks (S,), in order, of the states that can be reached from `starts`.

    Raises:
        TooManyStatesError: there are more than `most`; they are not counted any further.
    """
    moves = AttackMoves(network)
    frontier = np.unique(moves.masks(starts))
    layers, counted = [frontier], frontier.size
    # Every success adds a node, so this ends, and from one start no state is in two layers.
    while frontier.size:
        found, number = [frontier[:0]], 0
        for block in np.array_split(frontier, 1 + frontier.size * moves.target_bit.size // BLOCK):
            found.append(moves.following(block))
            number += found[-1].size
            if counted + number > most:
                found = [np.unique(np.concatenate(found))]
                number = found[0].size
                if counted + number > most:
                    raise TooManyStatesError
        frontier = np.unique(np.concatenate(found))
        layers.append(frontier)
        counted += frontier.size
    return np.unique(np.concatenate(layers))


def reached_nodes(edges: Collection[tuple[int, int]], footholds: Collection[int]) -> set[int]:
    """The nodes that can ever be compromised, with the footholds and `OUTSIDE`."""
    return _reached(_following(edges), {OUTSIDE, *footholds})


def reached_within(attacks: int, edges: Collection[tuple[int, int]], footholds: Collection[int]) -> set[int]:
    """The nodes that as many successful attacks in a row can compromise, with the footholds and `OUTSIDE`."""
    following = _following(edges)
    reached = new = {OUTSIDE, *footholds}
    for _ in range(attacks):
        new = {target for source in new for target in following.get(source, [])} - reached
        reached = reached | new
    return reached


def usable_edges(edges: Collection[tuple[int, int]], footholds: Collection[int]) -> set[tuple[int, int]]:
    """The edges that can be attacked in a state that can be reached: the source may fall before the target does."""
    following, start = _following(edges), {OUTSIDE, *footholds}
    before: dict[int, list[int]] = {}
    for source, target in edges:
        before.setdefault(target, []).append(source)
    usable: set[tuple[int, int]] = set()
    for target in before.keys() - start:
        reached = _reached(following, start, but=target)
        usable |= {(source, target) for source in before[target] if source in reached}
    return usable


def _following(edges: Iterable[tuple[int, int]]) -> dict[int, list[int]]:
    following: dict[int, list[int]] = {}
    for source, target in edges:
        following.setdefault(source, []).append(target)
    return following


def _reached(following: Mapping[int, list[int]], start: Iterable[int], but: int | None = None) -> set[int]:
    """Every node that is found from `start` without passing through one of them."""
    reached = set(start)
    pending = list(reached)
    while pending:
        new = set(following.get(pending.pop(), [])) - reached - {but}
        reached |= new
        pending += new
    return reached


def words(masks: np.ndarray) -> np.ndarray:
    """Bitmasks as 64-bit integers: (S,), or (S, words) of `WORD` nodes each, the first nodes first."""
    if masks.dtype != object:
        return masks
    number = 1 + (max(masks.tolist()).bit_length() - 1) // WORD
    return np.array(
        [[mask >> WORD * word & 2**WORD - 1 for word in range(number)] for mask in masks.tolist()], dtype=np.int64
    )
