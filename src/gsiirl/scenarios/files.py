"""Attack networks from a user's own file: GraphML or JSON (docs/scenarios.md has both formats)."""

import json
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from gsiirl.errors import InputError
from gsiirl.scenarios.network import OUTSIDE, AttackNetwork, Variant

Attributes = Mapping[str, Any]
Content = tuple[str | None, Sequence[Attributes], Sequence[Attributes]]
"""Name, nodes and edges as a file has them: nodes with an `id` or `name`, edges with `source` and `target`."""

NUMBERS = ("int", "long", "float", "double")
"""Numeric attribute types of GraphML."""


def read_network(path: str | Path, variant: Variant = "general_sum") -> AttackNetwork:
    """Read a network from a .graphml, .xml (GraphML) or .json file.

    Raises:
        InputError: when the file cannot be read or does not hold a valid network; it names the file and the element.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in READERS:
        raise InputError(str(path), f"is of unknown kind '{kind}'", f"give a file ending in {', '.join(READERS)}")
    try:
        name, nodes, edges = READERS[kind](path)
        return _network(name or path.stem, nodes, edges, variant)
    except InputError as error:
        raise InputError(f"{path}: {error.field}", error.problem, error.mend) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(str(path), f"cannot be read ({reason})", "give a readable file") from None


def _read_json(path: Path) -> Content:
    text = path.read_text(encoding="utf-8-sig")
    try:
        content = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError("file", f"is not JSON ({error})", "mend it or save it as JSON again") from None
    if not isinstance(content, dict):
        raise InputError("file", "holds no JSON object", 'give {"nodes": [...], "edges": [...]}')
    if content.get("directed", True) is not True:
        raise InputError("directed", "the graph is undirected", "give a directed graph: an attack has a direction")
    nodes = _objects(content, "nodes")
    edges = _objects(content, "links" if "links" in content and "edges" not in content else "edges")
    name = content.get("name")
    return name if isinstance(name, str) else None, nodes, edges


def _objects(content: Attributes, key: str) -> Sequence[Attributes]:
    listed = content.get(key)
    if not isinstance(listed, list) or not all(isinstance(entry, dict) for entry in listed):
        raise InputError(key, "there is no list of objects of this name", f'give "{key}": [{{...}}, ...]')
    return listed


def _read_graphml(path: Path) -> Content:
    # Imported where it is used: nothing else here needs it, and the command line starts without it.
    import networkx

    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, LookupError) as error:
        raise InputError("file", f"is not XML ({error})", "mend it or save it as GraphML again") from None
    _check_elements(root)
    _check_numbers(root)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            graph = networkx.read_graphml(path)
    except (networkx.NetworkXError, ValueError, LookupError, TypeError) as error:
        raise InputError("file", f"is not GraphML ({error})", "mend it or save it as GraphML again") from None
    if not graph.is_directed():
        raise InputError("edgedefault", "the graph is undirected", 'give edgedefault="directed"')
    nodes = [{**attributes, "id": node} for node, attributes in graph.nodes(data=True)]
    edges = [{**attributes, "source": i, "target": j} for i, j, attributes in graph.edges(data=True)]
    return None, nodes, edges


def _check_elements(root: ElementTree.Element) -> None:
    """Find what networkx mends in silence: it merges nodes of one id and adds nodes that only edges name."""
    known: set[str | None] = set()
    for identifier in (node.get("id") for node in root.iterfind(".//{*}node")):
        if identifier in known:
            raise _twice(identifier)
        known.add(identifier)
    for edge in root.iterfind(".//{*}edge"):
        for end in ("source", "target"):
            if edge.get(end) not in known:
                raise _dangling(edge.get("source"), edge.get("target"), end)


def _check_numbers(root: ElementTree.Element) -> None:
    """Find text where a number belongs: networkx would not say at which element."""
    keys = root.iterfind(".//{*}key")
    numeric = {key.get("id"): str(key.get("attr.name")) for key in keys if key.get("attr.type") in NUMBERS}
    labelled = [(f"node '{node.get('id')}'", node) for node in root.iterfind(".//{*}node")]
    labelled += [(f"edge '{edge.get('source')} -> {edge.get('target')}'", edge) for edge in root.iterfind(".//{*}edge")]
    for label, element in labelled:
        for entry in element.iterfind("{*}data"):
            if entry.get("key") in numeric:
                text = entry.text or ""
                try:
                    float(text)
                except ValueError:
                    raise InputError(numeric[entry.get("key")], f"{label} has '{text}'", "give a number") from None


def _twice(identifier: object) -> InputError:
    return InputError("nodes", f"node '{identifier}' is there twice", "give every node a name of its own")


def _dangling(source: object, target: object, end: str) -> InputError:
    missing = source if end == "source" else target
    problem = f"edge '{_shown(source)} -> {target}' has a {end} '{missing}' that is no node"
    return InputError("edges", problem, "add the node or correct the edge")


def _shown(source: object) -> object:
    return "outside" if source is None else source


def _network(name: str, nodes: Sequence[Attributes], edges: Sequence[Attributes], variant: Variant) -> AttackNetwork:
    index: dict[str, int] = {}
    names: list[str] = []
    footholds: list[int] = []
    value: list[float] = []
    criticality: list[float] = []
    for position, node in enumerate(nodes):
        identifier = _identifier(node, position)
        label = f"node '{identifier}'"
        if identifier in index:
            raise _twice(identifier)
        if _flag(node, "outside", label):
            index[identifier] = OUTSIDE
            continue
        index[identifier] = len(names)
        if _flag(node, "foothold", label):
            footholds.append(len(names))
        names.append(str(node.get("name", identifier)))
        value.append(_number(node, "value", label))
        criticality.append(_number(node, "criticality", label, default=value[-1]))

    ends: list[tuple[int, int]] = []
    numbers: dict[str, list[float]] = {"success_probability": [], "attack_cost": [], "block_cost": []}
    for position, edge in enumerate(edges):
        for end in ("source", "target"):
            if end not in edge:
                raise InputError("edges", f"edge number {position + 1} has no {end}", "name a node")
        source, target = edge["source"], edge["target"]
        if source is not None and str(source) not in index:
            raise _dangling(source, target, "source")
        if target is None or str(target) not in index:
            raise _dangling(source, target, "target")
        label = f"edge '{_shown(source)} -> {target}'"
        if index[str(target)] == OUTSIDE:
            raise InputError("edges", f"{label} leads outside", "remove it: what is outside cannot be attacked")
        ends.append((OUTSIDE if source is None else index[str(source)], index[str(target)]))
        numbers["success_probability"].append(_number(edge, "success_probability", label))
        numbers["attack_cost"].append(_number(edge, "attack_cost", label, default=0.0))
        numbers["block_cost"].append(_number(edge, "block_cost", label, default=1.0))

    return AttackNetwork(
        name=name,
        node_names=tuple(names),
        value=np.array(value),
        criticality=np.array(criticality),
        edge_source=np.array([source for source, _ in ends], dtype=np.int64),
        edge_target=np.array([target for _, target in ends], dtype=np.int64),
        success_probability=np.array(numbers["success_probability"]),
        attack_cost=np.array(numbers["attack_cost"]),
        block_cost=np.array(numbers["block_cost"]),
        footholds=tuple(footholds),
    ).with_variant(variant)


def _identifier(node: Attributes, position: int) -> str:
    identifier = node.get("id", node.get("name"))
    if isinstance(identifier, bool) or not isinstance(identifier, str | int):
        raise InputError("nodes", f"node number {position + 1} has no name", 'give it a "name"')
    return str(identifier)


def _flag(attributes: Attributes, key: str, label: str) -> bool:
    flag = attributes.get(key, False)
    if not isinstance(flag, bool):
        raise InputError(key, f"{label} has {flag!r}", "give true or false (in GraphML: attr.type boolean)")
    return flag


def _number(attributes: Attributes, key: str, label: str, default: float | None = None) -> float:
    number = attributes.get(key, default)
    if number is None:
        raise InputError(key, f"{label} has none", "give a number")
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise InputError(key, f"{label} has {number!r}", "give a number (in GraphML: attr.type double)")
    try:
        return float(number)
    except OverflowError:
        raise InputError(key, f"{label} has a number beyond all bounds", "give a smaller one") from None


READERS: Mapping[str, Callable[[Path], Content]] = {
    ".graphml": _read_graphml,
    ".xml": _read_graphml,
    ".json": _read_json,
}
