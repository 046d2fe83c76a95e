"""Changes of an attack network that `gsiirl transfer` takes a learner through: an edge less, an edge more, other odds.

A change is a text:

    remove-edge=A:B                   the edge A -> B is gone
    add-edge=A:B                      there is an edge A -> B, whose odds and costs are the means of the others
    add-edge=A:B:ODDS:ATTACK:BLOCK    the same with its probability of success, attack cost and block cost
    redraw=SEED                       every edge has another probability of success, uniform within `ODDS`

A and B are names of nodes, and A may be `outside`. Nodes, and what they are worth, stay as they are.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from gsiirl.errors import InputError
from gsiirl.scenarios import AttackNetwork
from gsiirl.scenarios.network import OUTSIDE, shown

ODDS = (0.2, 1.0)
"""Range of a probability of success that is drawn."""
FIELD = "--change"
FORMS = "give remove-edge=A:B, add-edge=A:B or redraw=SEED"
PER_EDGE = ("edge_source", "edge_target", "success_probability", "attack_cost", "block_cost")
DIGITS = 3
"""Decimals of what is drawn for an added edge, so that its text says all of it."""
MOST_SEED = 1_000_000


def changed(network: AttackNetwork, change: str) -> AttackNetwork:
    """The network after a change.

    Raises:
        InputError: the text is no change, names what is not there, or leaves nothing to attack.
    """
    kind, _, what = change.partition("=")
    match kind:
        case "remove-edge":
            return _without(network, what)
        case "add-edge":
            return _with(network, what)
        case "redraw":
            return _redrawn(network, what)
        case _:
            raise InputError(FIELD, f"'{shown(change)}' is no change of a network", FORMS)


def drawn(network: AttackNetwork, number: int, seed: int) -> list[str]:
    """`number` changes in turn: an edge less, an edge more, other odds; the same seed gives the same ones.

    No edge is removed or added twice. Where none is left to remove or to add, odds are drawn instead.
    """
    generator = np.random.default_rng(seed)
    removable = _shuffled(generator, [f"remove-edge={edge}" for edge in _pairs(network) if _can_go(network, edge)])
    addable = _shuffled(generator, [f"add-edge={edge}" for edge in _absent(network)])
    changes: list[str] = []
    for place in range(number):
        edges = (removable, addable, [])[place % 3]
        if not edges:
            changes.append(f"redraw={generator.integers(MOST_SEED)}")
        elif place % 3:
            changes.append(f"{edges.pop()}:{_numbers_of_an_edge(generator, network)}")
        else:
            changes.append(edges.pop())
    return changes


def carried_over(weights: np.ndarray, before: AttackNetwork, after: AttackNetwork) -> np.ndarray:
    """Weights (n, N + k E) of nodes, then of edges in k kinds, for the edges of the network after a change.

    An edge that was not there before has the mean of its kind: of its cost nothing was learned.
    """
    nodes, edges = len(before.node_names), len(before.edge_names)
    of_edges = weights[:, nodes:].reshape(len(weights), -1, edges)
    all_and_mean = np.concatenate([of_edges, of_edges.mean(axis=-1, keepdims=True)], axis=-1)
    known = {name: place for place, name in enumerate(before.edge_names)}
    places = [known.get(name, edges) for name in after.edge_names]
    return np.concatenate([weights[:, :nodes], all_and_mean[:, :, places].reshape(len(weights), -1)], axis=1)


def _without(network: AttackNetwork, edge: str) -> AttackNetwork:
    edges = _pairs(network)
    if edge not in edges:
        raise InputError(FIELD, f"remove-edge: there is no edge '{shown(edge)}'", f"choose from {', '.join(edges)}")
    place = edges.index(edge)
    fields = {field: np.delete(getattr(network, field), place) for field in PER_EDGE}
    try:
        return replace(network, **fields)
    except InputError as error:
        raise InputError(FIELD, f"without '{shown(edge)}' nothing can be attacked", "remove another edge") from error


def _with(network: AttackNetwork, what: str) -> AttackNetwork:
    absent = _absent(network)
    edge = _beginning(what, absent)
    if edge is None:
        known = _beginning(what, _pairs(network))
        problem = (
            f"add-edge: '{shown(what)}' is no edge between two nodes"
            if known is None
            else f"there is an edge '{known}'"
        )
        mend = "give A:B, names of nodes without an edge from A to B yet; B is no foothold"
        raise InputError(FIELD, problem, mend)
    source, target = absent[edge]
    odds, *costs = _numbers(what[len(edge) + 1 :]) or [
        float(np.mean(getattr(network, field))) for field in PER_EDGE[2:]
    ]
    added = dict(zip(PER_EDGE, (source, target, odds, *costs), strict=True))
    try:
        return replace(network, **{name: np.append(getattr(network, name), number) for name, number in added.items()})
    except InputError as error:
        raise InputError(FIELD, f"add-edge: {error.field}: {error.problem}", error.mend) from error


def _redrawn(network: AttackNetwork, seed: str) -> AttackNetwork:
    if not (seed.isascii() and seed.isdigit() and len(seed) <= 9 and int(seed) < MOST_SEED):
        raise InputError(FIELD, f"redraw: '{shown(seed)}' is no seed", f"give a whole number below {MOST_SEED:,}")
    odds = np.random.default_rng(int(seed)).uniform(*ODDS, size=len(network.edge_names))
    return replace(network, success_probability=odds)


def _beginning(text: str, edges: Iterable[str]) -> str | None:
    """The edge that the text names, alone or before numbers; the longest, as names may hold colons themselves."""
    return max((each for each in edges if text == each or text.startswith(f"{each}:")), key=len, default=None)


def _numbers(text: str) -> list[float]:
    """The three numbers of an added edge, or none where there is no text."""
    if not text:
        return []
    try:
        numbers = [float(each) for each in text.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) != 3:
        mend = "give probability of success, attack cost and block cost, as in add-edge=A:B:0.8:0.1:1"
        raise InputError(FIELD, f"add-edge: '{shown(text)}' is not three numbers", mend)
    return numbers


def _numbers_of_an_edge(generator: np.random.Generator, network: AttackNetwork) -> str:
    """Odds as they are redrawn, and costs between the least and the largest that there are."""
    ranges = (ODDS, *((each.min(), each.max()) for each in (network.attack_cost, network.block_cost)))
    return ":".join(f"{generator.uniform(low, high):.{DIGITS}f}" for low, high in ranges)


def _pairs(network: AttackNetwork) -> list[str]:
    """Every edge as A:B, in their order."""
    ends = zip(network.edge_source.tolist(), network.edge_target.tolist(), strict=True)
    return [_pair(network, source, target) for source, target in ends]


def _pair(network: AttackNetwork, source: int, target: int) -> str:
    return f"{'outside' if source == OUTSIDE else network.node_names[source]}:{network.node_names[target]}"


def _absent(network: AttackNetwork) -> dict[str, tuple[int, int]]:
    """Source and target of the edges that could be added: none that is there, none into a foothold.

    There are entry edges among them where the network has some already.
    """
    there = {*_pairs(network)}
    sources = [*([OUTSIDE] if (network.edge_source == OUTSIDE).any() else []), *range(len(network.node_names))]
    return {
        name: (source, target)
        for source in sources
        for target in range(len(network.node_names))
        if source != target and target not in network.footholds
        if (name := _pair(network, source, target)) not in there
    }


def _can_go(network: AttackNetwork, edge: str) -> bool:
    try:
        _without(network, edge)
    except InputError:
        return False
    return True


def _shuffled(generator: np.random.Generator, names: list[str]) -> list[str]:
    return [names[place] for place in generator.permutation(len(names))]
