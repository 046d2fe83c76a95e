"""An attack network from a plain topology: who is next to whom, and what each host is vulnerable to."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.errors import InputError, NetworkWarning, warn
from gsiirl.scenarios.file_content import FileContent, Numbered, names_of, numbered_of, some, some_names
from gsiirl.scenarios.network import OUTSIDE, AttackNetwork, shown
from gsiirl.scenarios.network_file import named, read_content
from gsiirl.scenarios.reachable import reached_nodes, usable_edges
from gsiirl.scenarios.vulnerabilities import CvssRule, Vulnerability, near, read_vulnerabilities

Pair = tuple[int, int]
"""Numbers of an edge's source (or `OUTSIDE`) and target."""
Say = Callable[[str], None]


@dataclass(frozen=True)
class BuiltNetwork:
    """The network, and for each of its edges the name of the vulnerability that is taken there."""

    network: AttackNetwork
    vulnerabilities: tuple[str, ...]

    def to_json_dict(self) -> Mapping[str, Any]:
        """What `read_network` reads, with the vulnerabilities' names beside it."""
        document = dict(self.network.to_json_dict())
        document["edges"] = [
            {**edge, "vulnerability": name} for edge, name in zip(document["edges"], self.vulnerabilities, strict=True)
        ]
        return document


def build_network(topology: Path, vulnerabilities: Path, footholds: Sequence[str], rule: CvssRule) -> BuiltNetwork:
    """The network in which every neighbour of a host may attack it, by the best of its vulnerabilities.

    Args:
        topology: a GraphML or JSON file; an undirected edge is one in both directions.
        vulnerabilities: a CSV file, see `read_vulnerabilities`.
        footholds: hosts that are compromised at the start.
        rule: what probability a CVSS score stands for.

    Warns:
        NetworkWarning: of what was left out, and of what was taken where nothing was given; nothing of what is refused.

    Raises:
        InputError: a file cannot be read, they do not fit each other, or no game comes of them.
    """
    notes: list[str] = []
    built = _built(topology, vulnerabilities, footholds, rule, notes)
    for note in notes:
        warn(note, NetworkWarning)
    return built


def _built(
    topology: Path, vulnerabilities: Path, footholds: Sequence[str], rule: CvssRule, notes: list[str]
) -> BuiltNetwork:
    """The network; what is to be said of it is added to `notes`."""

    def say(note: str) -> None:
        notes.append(f"{topology}: {note}")

    content = read_content(topology)
    for note in content.notes:
        say(note)
    with named(topology):
        numbered = numbered_of(content)
        names = names_of(numbered.hosts, say)
        ways = _ways(content, numbered, say)
    known = {" ".join(name.split()): node for name, node in numbered.index.items()}
    # The name is what is shown: it goes before the identifier of another host.
    known |= {" ".join(name.split()): node for node, name in enumerate(names)}
    start = {node for node, host in enumerate(numbered.hosts) if host.attributes.get("foothold")}
    start |= set(_found("foothold", footholds, known, numbered))

    table = read_vulnerabilities(vulnerabilities, rule)
    notes += [f"{vulnerabilities}: {note}" for note in table.notes]
    with named(vulnerabilities):
        _found("host", [row.host for row in table.rows], known, numbered)
        _found("source", [row.source for row in table.rows if row.source], {**known, "outside": OUTSIDE}, numbered)
        exploits = _best(table.rows, known, ways)
        value = _values(table.rows, known)
    if not start and all(source != OUTSIDE for source, _ in exploits):
        raise InputError("foothold", "nothing is compromised at the start", "add --foothold NAME")

    reached = reached_nodes(exploits, start)
    usable = usable_edges(exploits, start)
    used = {pair: row for pair, row in exploits.items() if pair in usable}
    vulnerable = {known[row.host] for row in table.rows if row.probability is not None}
    closed = set(range(len(names))) - vulnerable - start
    lost = sum(target in closed for _, target in ways)
    if closed:
        edges = f"no edge to them ({lost} left out)" if lost else "not to be attacked"
        say(f"no vulnerability, so {edges}: {_some_of(closed, names)}")
    if vulnerable - reached:
        say(f"vulnerable, but no attacker gets next to them: {_some_of(vulnerable - reached, names)}")
    more = sum(pair not in used for pair in ways) - lost
    if more:
        edges = f"{more} more edge{'s' * (more > 1)}"
        say(f"{edges} left out: back to where an attacker came from, or no exploit works from there")
    for node in reached - start - {OUTSIDE}:
        own = numbered.hosts[node].attributes.get("value")
        if node not in value and own is not None:
            value[node] = own
    _check_values(value, reached - start - {OUTSIDE}, names, say)
    worth = np.array([value.get(node, 0.0) for node in range(len(names))])
    with named(topology):
        network = AttackNetwork(
            name=content.name or topology.stem,
            node_names=names,
            value=worth,
            criticality=worth,
            edge_source=np.array([source for source, _ in used]),
            edge_target=np.array([target for _, target in used]),
            success_probability=np.array([row.probability for row in used.values()]),
            attack_cost=np.array([row.attack_cost for row in used.values()]),
            block_cost=np.ones(len(used)),
            footholds=tuple(start),
        )
    return BuiltNetwork(network, tuple(row.name for row in used.values()))


def _ways(content: FileContent, numbered: Numbered, say: Say) -> dict[Pair, None]:
    """The pairs of neighbours, as attacker and attacked."""
    ways: dict[Pair, None] = {}
    both = own = 0
    for edge, (source, target) in zip(content.edges, numbered.ends, strict=True):
        own += source == target
        ways[source, target] = None
        if not edge.directed and source != OUTSIDE:
            both += source != target
            ways[target, source] = None
    if both:
        say(f"undirected edges ({both} of {len(content.edges)}) are read as attacks in both directions")
    if own:
        say(f"edges from a host to itself ({own}) are left out")
    given = {name for listed in (*content.nodes, *content.edges) for name in listed.attributes}
    if strange := given - {"name", "value", "foothold", "outside"}:
        say(f"not read of the topology: {', '.join(sorted(strange))}")
    return {pair: None for pair in ways if pair[0] != pair[1]}


def _found(field: str, typed: Sequence[str], known: Mapping[str, int], numbered: Numbered) -> list[int]:
    """The numbers of names; all that are not known are named at once."""
    names = [" ".join(name.split()) for name in typed]
    told = []
    for name in dict.fromkeys(name for name in names if name not in known):
        same = [host.identifier for host in numbered.hosts if " ".join((host.label or "").split()) == name]
        ids = f" (a label of several: give an id, {some([shown(each) for each in same], 3)})"
        told.append(f"'{shown(name)}'{ids if same else near(name, list(known))}")
    if told:
        raise InputError(field, f"not in the topology: {some(told, 8)}", "correct the names")
    outside = [name for name in names if known[name] == OUTSIDE]
    if outside and field != "source":
        raise InputError(field, f"'{shown(outside[0])}' is no host, but a place outside", "name a host")
    return [known[name] for name in names]


def _best(rows: Sequence[Vulnerability], known: Mapping[str, int], ways: Collection[Pair]) -> dict[Pair, Vulnerability]:
    """Of every pair that can be attacked the likeliest vulnerability, then the cheapest, then the first."""
    into: dict[int, list[int]] = {}
    for source, target in ways:
        into.setdefault(target, []).append(source)
    best: dict[Pair, Vulnerability] = {}
    for row in rows:
        target = known[row.host]
        if row.source is None:
            sources = into.get(target, [])
        else:
            # Whatever is outside needs no edge of the topology.
            sources = [known.get(row.source, OUTSIDE)]
            if sources != [OUTSIDE] and (sources[0], target) not in ways:
                problem = f"'{shown(row.source)}' has no edge to '{shown(row.host)}' in the topology"
                raise InputError(
                    f"line {row.line}, source", problem, "correct it, or leave it empty for all neighbours"
                )
        for source in sources if row.probability is not None else []:
            old = best.get((source, target))
            if old is None or _order(row) < _order(old):
                best[source, target] = row
    return best


def _order(row: Vulnerability) -> tuple[float, float]:
    assert row.probability is not None
    return -row.probability, row.attack_cost


def _values(rows: Sequence[Vulnerability], known: Mapping[str, int]) -> dict[int, float]:
    """What hosts are worth; all rows of one agree."""
    given: dict[int, tuple[float, int]] = {}
    for row in rows:
        if row.value is None:
            continue
        value, line = given.setdefault(known[row.host], (row.value, row.line))
        if value != row.value:
            problem = f"'{shown(row.host)}' has {row.value:g}, and {value:g} in line {line}"
            raise InputError(f"line {row.line}, value", problem, "give a host one value")
    return {node: value for node, (value, _) in given.items()}


def _check_values(value: Mapping[int, float], hosts: Collection[int], names: Sequence[str], say: Say) -> None:
    """Refuse a game that is about nothing."""
    if not hosts:
        raise InputError(
            "foothold",
            "no host can be attacked: none with a vulnerability is next to a foothold",
            "add --foothold NAME, or rows with the source outside",
        )
    if all(value.get(node, 0.0) == 0 for node in hosts):
        raise InputError(
            "value", "no host that can be attacked is worth anything", "add a column value: what an attacker gains"
        )
    without = [node for node in hosts if node not in value]
    if without:
        say(f"no value, so 0 is taken: {_some_of(without, names)}")


def _some_of(hosts: Collection[int], names: Sequence[str]) -> str:
    return some_names([names[node] for node in sorted(hosts)], 8)
