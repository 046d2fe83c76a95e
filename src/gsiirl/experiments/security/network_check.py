"""What a network file holds, what it lacks for a game, and what a run on it with the default settings takes."""

import shlex
import textwrap
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from gsiirl.errors import InputError, NetworkWarning
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.security.cost import check_memory, memory_needed, seconds_needed
from gsiirl.program.available_memory import available_memory
from gsiirl.scenarios import is_own_file, load_network
from gsiirl.scenarios.file_content import (
    EDGE,
    NODE,
    FileContent,
    Missing,
    missing,
    names_of,
    network_of,
    numbered_of,
    some,
    some_names,
)
from gsiirl.scenarios.network import OUTSIDE, AttackNetwork, shown
from gsiirl.scenarios.network_file import named, read_content
from gsiirl.scenarios.reachable import reached_nodes, reached_within, usable_edges

WIDTH = 80
READ = {"id", "source", "target", "label", "directed", *NODE.attributes, *EDGE.attributes}
"""Names of what is read of nodes and edges."""
WAY_IN = Missing("foothold", "nodes", 1, [])
"""Said to be missing where there is no edge from outside either."""


@dataclass(frozen=True)
class NetworkCheck:
    """What was found in a file; None and empty where a plain topology has no such thing yet."""

    file: str
    hosts: int
    edges: int
    undirected: int
    """How many of the file's edges are undirected; of a game, `edges` counts each as two."""
    footholds: list[str]
    entries: list[str]
    """Edges from outside."""
    missing: list[Missing]
    """What a game needs, and the file has not; empty for a game."""
    ignored: dict[str, list[str]]
    """Names of attributes of nodes and of edges that are not read."""
    notes: list[str]
    unreachable: list[str] = field(default_factory=list)
    too_far: list[str] = field(default_factory=list)
    """Hosts that cannot fall within an episode of the default settings, though they can in a longer one."""
    unusable_edges: list[str] = field(default_factory=list)
    states: int | None = None
    """None also where there are too many to count."""
    memory_bytes: float | None = None
    allowed_bytes: float | None = None
    """Half of what is free."""
    seconds: float | None = None
    refused: str | None = None
    """Why a run with the default settings would not begin."""

    @property
    def is_game(self) -> bool:
        """Whether it has all that a game needs."""
        return not self.missing

    @property
    def can_run(self) -> bool:
        """Whether a run with the default settings would begin."""
        return self.is_game and self.refused is None

    def to_json_dict(self) -> dict[str, Any]:
        """Everything, for other programs."""
        return {"game": self.is_game, "can_run": self.can_run, **asdict(self)}

    @property
    def _edges(self) -> str:
        if self.undirected and not self.is_game:
            return f"{self.edges}, of which {self.undirected} undirected: attacks in both directions"
        return str(self.edges)

    def as_text(self) -> str:
        """Everything in lines of at most `WIDTH` columns."""
        default = SecurityConfig()
        rows: list[tuple[str, str]] = [("hosts", str(self.hosts)), ("edges", self._edges)]
        rows += [("footholds", _listed(self.footholds)), ("entries", _listed(self.entries))]
        if self.is_game:
            rows += [
                ("not reached", _listed(self.unreachable)),
                *(
                    [("too far", f"{_listed(self.too_far)}: an episode has {default.horizon} steps (--horizon)")]
                    if self.too_far
                    else []
                ),
                ("never used", _listed(self.unusable_edges)),
                ("states", "too many to count" if self.states is None else f"{self.states:,} can be reached"),
            ]
        if self.memory_bytes is not None:
            half = "" if self.allowed_bytes is None else f"; {_gigabytes(self.allowed_bytes)} is half of what is free"
            rows.append(("memory", f"{_gigabytes(self.memory_bytes)} at most{half}"))
        if self.seconds is not None:
            settings = f"{default.algorithm}, {default.seeds} seeds, {default.iterations} iterations"
            rows.append(("time", f"roughly {_duration(self.seconds)} ({settings})"))
        if self.refused:
            rows.append(("refused", self.refused))
        rows += [("missing", _in_words(each)) for each in self.missing] or [("missing", "nothing")]
        ignored = [("ignored", f"of {word}: {some(names, 12)}") for word, names in self.ignored.items() if names]
        rows += ignored or [("ignored", "nothing")]
        rows += [("note", line) for line in self.notes]
        title = f"{shown(self.file, 200)}: {'a game' if self.is_game else 'not a game yet: something is missing'}"
        lines, before = [title, ""], None
        for word, text in rows:
            head = f"{'' if word == before else word:<13}"
            lines += textwrap.wrap(text, WIDTH, initial_indent=head, subsequent_indent=" " * 13, break_on_hyphens=False)
            before = word
        if not self.is_game:
            lines.append(f"{'next':<13}gsiirl network build {shlex.quote(shown(self.file, 200))} \\")
            lines.append(f"{'':<13}--vulnerabilities FILE.csv --foothold NAME --out FILE.json")
        return "\n".join(lines)


def check_network(file: str) -> NetworkCheck:
    """What is in a file, and what a run on it takes.

    Raises:
        InputError: it cannot be read, or holds something that no game may have.
    """
    ignored: dict[str, list[str]] = {}
    undirected = 0
    if is_own_file(file):
        content = read_content(Path(file))
        ignored = _ignored(content)
        undirected = sum(not edge.directed for edge in content.edges)
        if (plain := _plain_topology(file, content, ignored)) is not None:
            return plain
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", NetworkWarning)
        network = load_network(file)
        config = SecurityConfig(graph=file).resolved()
    notes = dict.fromkeys(str(warning.message).removeprefix(f"{Path(file)}: ") for warning in said)

    ends = list(zip(network.edge_source.tolist(), network.edge_target.tolist(), strict=True))
    reached, usable = reached_nodes(ends, network.footholds), usable_edges(ends, network.footholds)
    near = reached_within(config.horizon, ends, network.footholds)
    states, refused = _counted_states(config, network)
    memory = None if states is None else memory_needed(config, network, states, config.seeds)
    available = available_memory()
    names, edge_names = network.node_names, network.edge_names
    return NetworkCheck(
        file=file,
        hosts=len(names),
        edges=len(ends),
        undirected=undirected,
        footholds=[names[node] for node in network.footholds],
        entries=[name for name, (source, _) in zip(edge_names, ends, strict=True) if source == OUTSIDE],
        missing=[],
        ignored=ignored,
        notes=list(notes),
        unreachable=[name for node, name in enumerate(names) if node not in reached],
        too_far=[name for node, name in enumerate(names) if node in reached - near],
        unusable_edges=[name for name, pair in zip(edge_names, ends, strict=True) if pair not in usable],
        states=states,
        memory_bytes=memory,
        allowed_bytes=None if available is None else available / 2,
        seconds=None if states is None else seconds_needed(config, network, states),
        refused=refused,
    )


def _plain_topology(file: str, content: FileContent, ignored: dict[str, list[str]]) -> NetworkCheck | None:
    """What is in a file that lacks something; None for one that lacks nothing."""
    notes: list[str] = []
    with named(Path(file)):
        numbered = numbered_of(content)
    names = names_of(numbered.hosts, lambda _: None)
    lacking = missing(content, numbered, names)
    footholds = [
        name for name, host in zip(names, numbered.hosts, strict=True) if host.attributes.get("foothold", False)
    ]
    entries = [f"outside -> {shown(names[target])}" for source, target in numbered.ends if source == OUTSIDE]
    if not footholds and not entries:
        lacking.append(WAY_IN)
    if not lacking:
        return None
    # It has something to say of the file before it refuses what is missing.
    with suppress(InputError):
        network_of(content, Path(file).stem, "general_sum", notes.append)
    return NetworkCheck(
        file=file,
        hosts=len(names),
        edges=len(numbered.ends),
        undirected=sum(not edge.directed for edge in content.edges),
        footholds=footholds,
        entries=entries,
        missing=lacking,
        ignored=ignored,
        notes=notes,
    )


def _ignored(content: FileContent) -> dict[str, list[str]]:
    return {
        f"{kind.word}s": [shown(name) for name in sorted(content.attribute_names[kind] - READ)] for kind in (NODE, EDGE)
    }


def _in_words(lacking: Missing) -> str:
    if lacking is WAY_IN:
        return "a way in: no node is a foothold, and no edge comes from outside"
    which = "" if len(lacking.without) == lacking.total else f" ({some(lacking.without, 8)})"
    return f"{lacking.attribute} of {len(lacking.without)} of {lacking.total} {lacking.of}{which}"


def _counted_states(config: SecurityConfig, network: AttackNetwork) -> tuple[int | None, str | None]:
    """How many states can be reached, unless they are too many; and why a run is refused, if it is."""
    try:
        return check_memory(config, network), None
    except InputError as refusal:
        why = f"{refusal.problem}; {refusal.mend}"
    try:
        return check_memory(replace(config, seeds=1), network), why
    except InputError:
        return None, why


def _listed(names: Sequence[str]) -> str:
    return some_names(names, 8) or "none"


def _gigabytes(size: float) -> str:
    return f"{size / 1e9:,.1f} GB" if size >= 1e8 else f"{max(size / 1e6, 1):,.0f} MB"


def _duration(seconds: float) -> str:
    """A time in words, as roughly as it is known."""
    for unit, length in (("days", 86400), ("hours", 3600), ("minutes", 60)):
        if seconds >= 1.5 * length:
            return f"{seconds / length:,.0f} {unit}"
    return "a minute"
