"""What a network file lists, whatever its format, and the attack network made of it."""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gsiirl.errors import InputError
from gsiirl.scenarios.network import OUTSIDE, AttackNetwork, Variant, check_number, shown

HARDLY_EVER = 0.01
"""Success probability below which a first attack is not seen in a usual number of episodes."""


@dataclass(frozen=True)
class Kind:
    """Nodes, edges or both, and the attributes that we use of them."""

    word: str
    numbers: tuple[str, ...]
    flags: tuple[str, ...] = ()
    texts: tuple[str, ...] = ()

    @property
    def attributes(self) -> tuple[str, ...]:
        """Names of all of them."""
        return self.numbers + self.flags + self.texts


NODE = Kind("node", numbers=("value", "criticality"), flags=("foothold", "outside"), texts=("name",))
EDGE = Kind("edge", numbers=("success_probability", "attack_cost", "block_cost"))
DIRECTION = Kind("direction", numbers=(), flags=("directed",))
"""What JSON says of a graph and of an edge; GraphML has words of its own for it."""


@dataclass(frozen=True)
class ListedNode:
    """A node as the file has it."""

    identifier: str
    attributes: Mapping[str, Any]
    """Of ours, those that it has."""
    label: str | None = None
    """What drawing programs show: the name, where it is no other node's as well."""


@dataclass(frozen=True)
class ListedEdge:
    """An edge as the file has it; its ends are identifiers of nodes, and a source None is outside."""

    source: str | None
    target: str
    directed: bool
    attributes: Mapping[str, Any]
    """Of ours, those that it has."""


@dataclass(frozen=True)
class FileContent:
    """All that a file lists."""

    nodes: list[ListedNode] = field(default_factory=list)
    edges: list[ListedEdge] = field(default_factory=list)
    name: str | None = None
    groups: dict[str, Sequence[str]] = field(default_factory=dict)
    """What is no host, but a frame that a drawing has around some: by identifier, our attributes that it has."""
    attribute_names: dict[Kind, set[str]] = field(default_factory=lambda: {NODE: set(), EDGE: set()})
    """Names of all attributes, ours or not."""
    notes: list[str] = field(default_factory=list)
    """What the reader has to tell the user."""


@dataclass(frozen=True)
class Numbered:
    """The hosts of a file, each known by its place, and the source and target of every edge as such numbers."""

    hosts: list[ListedNode]
    ends: list[tuple[int, int]]
    index: Mapping[str, int]
    """Number of every node by its identifier; `OUTSIDE` for a place outside."""


@dataclass(frozen=True)
class Missing:
    """An attribute that a game needs, and which nodes or edges of how many have none."""

    attribute: str
    of: str
    """`nodes` or `edges`."""
    total: int
    without: list[str]


def edge_label(source: str | None, target: str) -> str:
    """How messages call an edge."""
    return f"edge '{'outside' if source is None else shown(source)} -> {shown(target)}'"


def network_of(content: FileContent, name: str, variant: Variant, say: Callable[[str], None]) -> AttackNetwork:
    """The network of what a file lists.

    Args:
        content: what the file lists.
        name: the network's, where the file has none.
        variant: the network's.
        say: is given a line for everything that the user should know of.

    Raises:
        InputError: when it is no valid network.
    """
    mistaken = {
        wrong: right for kind, names in content.attribute_names.items() for wrong, right in _mistaken(names, kind)
    }
    for note in content.notes:
        say(note)
    if mistaken:
        pairs = [f"'{shown(wrong)}' (did you mean {right}?)" for wrong, right in sorted(mistaken.items())]
        say(f"not read: {some(pairs, 6)}")

    ignored = [f"{', '.join(given)} of '{shown(group)}'" for group, given in content.groups.items() if given]
    if ignored:
        say(f"groups are no hosts, so not read: {some(ignored, 3)}")

    numbered = numbered_of(content)
    hosts, ends = numbered.hosts, numbered.ends
    names = names_of(hosts, say)
    _refuse_missing(missing(content, numbered, names), mistaken)

    attacks = _attacks(content.edges, ends, names, say)
    edges = attacks.values()
    network = AttackNetwork(
        name=content.name or name,
        node_names=names,
        value=np.array([node.attributes["value"] for node in hosts]),
        criticality=np.array([node.attributes.get("criticality", node.attributes["value"]) for node in hosts]),
        edge_source=np.array([source for source, _ in attacks]),
        edge_target=np.array([target for _, target in attacks]),
        success_probability=np.array([edge["success_probability"] for edge in edges]),
        attack_cost=np.array([edge.get("attack_cost", 0.0) for edge in edges]),
        block_cost=np.array([edge.get("block_cost", 1.0) for edge in edges]),
        footholds=tuple(node for node, host in enumerate(hosts) if host.attributes.get("foothold", False)),
    ).with_variant(variant)
    start = [OUTSIDE, *network.footholds]
    first = np.isin(network.edge_source, start) & ~np.isin(network.edge_target, start)
    likeliest = network.success_probability[first].max()
    if likeliest < HARDLY_EVER:
        say(f"a first attack will hardly ever succeed: its success_probability is at most {likeliest:g} a try")
    return network


def numbered_of(content: FileContent) -> Numbered:
    """The hosts and edges of a file by number.

    Raises:
        InputError: there are none, or an edge has ends that it cannot have.
    """
    index = _index(content.nodes)
    hosts = [node for node in content.nodes if index[node.identifier] != OUTSIDE]
    ends = [_ends(edge, index, content.groups) for edge in content.edges]
    for field_name, listed in (("nodes", hosts), ("edges", ends)):
        if not listed:
            raise InputError(field_name, f"there are 0 {field_name}", "give at least one")
    return Numbered(hosts, ends, index)


def _mistaken(names: Iterable[str], kind: Kind) -> Iterator[tuple[str, str]]:
    """Names that are not ours, but would be after a slip, and the one meant."""
    for name in names:
        if name not in kind.attributes and len(name) < 100:
            plain = "".join(filter(str.isalnum, name)).lower()
            meant = next((own for own in kind.attributes if _within_one_edit(plain, own.replace("_", ""))), None)
            if meant is not None:
                yield name, meant


def _within_one_edit(first: str, second: str) -> bool:
    """Whether a letter added, dropped, changed or swapped with the next makes one of the other, or nothing need be."""
    same = next(
        (k for k, (a, b) in enumerate(zip(first, second, strict=False)) if a != b), min(len(first), len(second))
    )
    first, second = first[same:], second[same:]
    swapped = first[:2] == second[1::-1] and first[2:] == second[2:]
    return swapped or first == second or second == first[1:] or first == second[1:] or first[1:] == second[1:]


def _index(nodes: Iterable[ListedNode]) -> dict[str, int]:
    """Number of every host by its identifier; `OUTSIDE` for a place outside."""
    index: dict[str, int] = {}
    hosts = 0
    for node in nodes:
        if node.identifier in index:
            raise InputError(
                "nodes", f"node '{shown(node.identifier)}' is there twice", "give every node a name of its own"
            )
        outside = node.attributes.get("outside", False)
        index[node.identifier] = OUTSIDE if outside else hosts
        hosts += not outside
    return index


def _ends(edge: ListedEdge, index: Mapping[str, int], groups: Collection[str]) -> tuple[int, int]:
    """The attack that an edge stands for: the numbers of its source and its target."""
    label = edge_label(edge.source, edge.target)
    for end, identifier in (("source", edge.source), ("target", edge.target)):
        if identifier is None:
            continue
        problem = f"{label} has a {end} '{shown(identifier)}' that is"
        if identifier in groups:
            raise InputError("edges", f"{problem} a group of nodes", "draw it to a node in the group")
        if identifier not in index:
            raise InputError("edges", f"{problem} no node", "add the node or correct the edge")
    source = OUTSIDE if edge.source is None else index[edge.source]
    target = index[edge.target]
    if not edge.directed and target == OUTSIDE:
        source, target = target, source
    if target == OUTSIDE:
        raise InputError("edges", f"{label} leads outside", "remove it: what is outside cannot be attacked")
    return source, target


def names_of(hosts: Sequence[ListedNode], say: Callable[[str], None]) -> tuple[str, ...]:
    """What to call the hosts: the name given, or a label that fits no other host as well, or the identifier."""
    labels = [" ".join((host.label or "").split()) for host in hosts]
    wanted = [
        host.attributes.get("name") or label or host.identifier for host, label in zip(hosts, labels, strict=True)
    ]
    users, identifiers = Counter(wanted), {host.identifier for host in hosts}
    names: list[str] = []
    ambiguous: dict[str, None] = {}
    for host, name in zip(hosts, wanted, strict=True):
        if not host.attributes.get("name") and name != host.identifier and (users[name] > 1 or name in identifiers):
            ambiguous[name] = None
            name = host.identifier
        try:
            name.encode()
        except UnicodeEncodeError:
            raise InputError("nodes", f"the name '{shown(name)}' holds half a character", "write it anew") from None
        names.append(name)
    if ambiguous:
        labels = [f"'{shown(label)}'" for label in ambiguous]
        say(f"labels that fit several nodes: {some(labels, 3)}; these nodes are called by their ids")
    return tuple(names)


def _attacks(
    edges: Sequence[ListedEdge],
    ends: Sequence[tuple[int, int]],
    names: Sequence[str],
    say: Callable[[str], None],
) -> Mapping[tuple[int, int], Mapping[str, Any]]:
    """Attributes of every attack, by its source and target: of parallel edges the best, of undirected ones two."""
    parallel: dict[tuple[int, int], list[Mapping[str, Any]]] = {}
    both_ways = 0
    for edge, (source, target) in zip(edges, ends, strict=True):
        for attribute, number in edge.attributes.items():
            check_number(attribute, edge_label(edge.source, edge.target), number)
        parallel.setdefault((source, target), []).append(edge.attributes)
        if not edge.directed and source not in (OUTSIDE, target):
            both_ways += 1
            parallel.setdefault((target, source), []).append(edge.attributes)
    if both_ways:
        say(f"undirected edges ({both_ways} of {len(edges)}) are read as attacks in both directions")
    several = [f"{len(same)} edges '{_attack(names, *pair)}'" for pair, same in parallel.items() if len(same) > 1]
    if several:
        say(f"{some(several, 3)}: of parallel edges the likeliest is taken, then the cheapest")
    return {pair: min(same, key=_likeliest_then_cheapest) for pair, same in parallel.items()}


def missing(content: FileContent, numbered: Numbered, names: Sequence[str]) -> list[Missing]:
    """The attributes that a game needs and that a node or an edge has not."""
    values = [
        f"node '{shown(name)}'"
        for host, name in zip(numbered.hosts, names, strict=True)
        if "value" not in host.attributes
    ]
    probabilities = [
        f"edge '{_attack(names, *pair)}'"
        for edge, pair in zip(content.edges, numbered.ends, strict=True)
        if "success_probability" not in edge.attributes
    ]
    both = (
        Missing("value", "nodes", len(numbered.hosts), values),
        Missing("success_probability", "edges", len(numbered.ends), probabilities),
    )
    return [each for each in both if each.without]


def _refuse_missing(lacking: Sequence[Missing], mistaken: Mapping[str, str]) -> None:
    """Name everything that is missing at once."""
    if not lacking:
        return
    attributes = [each.attribute for each in lacking]
    mend = "give a number"
    slips = [f"'{shown(wrong)}' to {right}" for wrong, right in mistaken.items() if right in attributes]
    if slips:
        mend += f", or rename {some(slips, 2)}"
    if sum(len(each.without) for each in lacking) == 1:
        raise InputError(attributes[0], f"{lacking[0].without[0]} has none", mend)
    problem = " and ".join(
        f"{len(each.without)} of {each.total} {each.of} have no {each.attribute} ({some(each.without, 2)})"
        for each in lacking
    )
    raise InputError(", ".join(attributes), problem, mend)


def _likeliest_then_cheapest(edge: Mapping[str, Any]) -> tuple[float, float]:
    return -edge["success_probability"], edge.get("attack_cost", 0.0)


def _attack(names: Sequence[str], source: int, target: int) -> str:
    return f"{'outside' if source == OUTSIDE else shown(names[source])} -> {shown(names[target])}"


def some_names(names: Sequence[str], number: int) -> str:
    """The first names, and how many more there are; one that holds a comma is quoted."""
    return some([f"'{shown(name)}'" if "," in name else shown(name) for name in names], number)


def some(texts: Sequence[str], number: int) -> str:
    """The first of them, and how many more there are."""
    more = [f"{len(texts) - number} more"] if len(texts) > number else []
    return ", ".join([*texts[:number], *more])
