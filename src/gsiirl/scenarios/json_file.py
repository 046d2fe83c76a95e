"""Networks in JSON: our own format (that of `game.json`), and networkx's node-link format."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from gsiirl.errors import InputError
from gsiirl.scenarios.file_content import DIRECTION, EDGE, NODE, FileContent, Kind, ListedEdge, ListedNode, edge_label
from gsiirl.scenarios.network import shown


class _Object(dict[str, Any]):
    """A JSON object that remembers which keys it was given twice: `dict` keeps the last in silence."""

    def __init__(self, pairs: Sequence[tuple[str, Any]]) -> None:
        super().__init__(pairs)
        self.twice: set[str] = set()
        if len(self) < len(pairs):
            seen: set[str] = set()
            for key, _ in pairs:
                (self.twice if key in seen else seen).add(key)


def read_json(content: bytes) -> FileContent:
    """What the file lists.

    Raises:
        InputError: when it is no JSON, or what a network needs is not there or of the wrong type.
    """
    document = _parse(content)
    if not isinstance(document, _Object):
        raise InputError("file", "holds no JSON object", 'give {"nodes": [...], "edges": [...]}')
    _refuse_twice(document, ("name", "directed", "nodes", "edges", "links"), "the file")
    if document.get("edges") is not None and document.get("links") is not None:
        raise InputError("links", "the file has both edges and links", "put all of them under edges")
    directed = _flag(document, "directed", "the graph")
    nodes = _objects(document, "nodes")
    edges = _objects(document, "edges" if document.get("links") is None else "links")
    name = document.get("name")
    return FileContent(
        name=name if isinstance(name, str) and name else None,
        nodes=[_node(node, position) for position, node in enumerate(nodes, start=1)],
        edges=[_edge(edge, position, directed is not False) for position, edge in enumerate(edges, start=1)],
        attribute_names={
            NODE: {key for node in nodes for key in node},
            EDGE: {key for edge in edges for key in edge},
            DIRECTION: {key for entry in (document, *edges) for key in entry},
        },
    )


def _parse(content: bytes) -> Any:
    encoding = json.detect_encoding(content)
    if not encoding.startswith("utf-8"):
        raise InputError("file", f"is in {encoding[:6].upper()}", "save it as UTF-8")
    try:
        return json.loads(content.decode("utf-8-sig"), object_pairs_hook=_Object)
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError("file", f"is not UTF-8 text (line {line})", "save it as UTF-8") from None
    except (json.JSONDecodeError, RecursionError) as error:
        raise InputError("file", f"is not JSON ({error})", "mend it or save it as JSON again") from None
    except ValueError:
        # Python converts no number of more than some thousand digits.
        raise InputError("file", "holds a number of thousands of digits", "give a shorter one") from None


def _objects(document: _Object, key: str) -> list[_Object]:
    listed = document.get(key)
    if not isinstance(listed, list) or not all(isinstance(entry, _Object) for entry in listed):
        raise InputError(key, "there is no list of objects of this name", f'give "{key}": [{{...}}, ...]')
    return listed


def _refuse_twice(entry: _Object, keys: Sequence[str], label: str) -> None:
    for key in keys:
        if key in entry.twice:
            raise InputError(key, f"{label} has it twice", "keep one of the two")


def _node(node: _Object, position: int) -> ListedNode:
    label, name = node.get("label"), node.get("name")
    identifier = next((node[key] for key in ("id", "name", "label") if node.get(key) is not None), None)
    if identifier is None:
        raise InputError("nodes", f"node number {position} has no name", 'give it a "name"')
    identifier = _name(identifier, f"node number {position}", "id" if node.get("id") is not None else "name")
    described = f"node '{shown(identifier)}'"
    _refuse_twice(node, ("id", "label", *NODE.attributes), described)
    return ListedNode(
        identifier=identifier,
        label=label if isinstance(label, str) else None,
        attributes=_attributes(node, NODE, described)
        | ({} if name is None else {"name": _name(name, described, "name")}),
    )


def _edge(edge: _Object, position: int, directed: bool) -> ListedEdge:
    for end in ("source", "target"):
        if end not in edge:
            raise InputError("edges", f"edge number {position} has no {end}", 'name a node as "source" and "target"')
    if edge["target"] is None:
        raise InputError("edges", f"edge number {position} has the target null", "name a node")
    source, target = (
        None if edge[end] is None else _name(edge[end], f"edge number {position}", end) for end in ("source", "target")
    )
    assert target is not None
    described = edge_label(source, target)
    _refuse_twice(edge, ("source", "target", "directed", *EDGE.attributes), described)
    own = _flag(edge, "directed", described)
    return ListedEdge(source, target, directed if own is None else own, _attributes(edge, EDGE, described))


def _attributes(entry: _Object, kind: Kind, label: str) -> dict[str, Any]:
    found: dict[str, Any] = {name: _number(entry, name, label) for name in kind.numbers}
    found |= {name: _flag(entry, name, label) for name in kind.flags}
    return {name: content for name, content in found.items() if content is not None}


def _name(name: object, label: str, key: str) -> str:
    """Text as it is, numbers as text: a table of numbers makes 1.0 of an id that was 1."""
    if isinstance(name, float) and math.isfinite(name):
        return str(int(name)) if name.is_integer() and abs(name) < 2**53 else repr(name)
    if isinstance(name, bool) or not isinstance(name, str | int):
        raise InputError(key, f"{label} has {_as_json(name)}", "give a text or a number")
    return str(name)


def _number(entry: Mapping[str, Any], key: str, label: str) -> float | None:
    number = entry.get(key)
    if number is None:
        return None
    if isinstance(number, bool) or not isinstance(number, int | float):
        raise InputError(key, f"{label} has {_as_json(number)}", "give a number")
    try:
        return float(number)
    except OverflowError:
        raise InputError(key, f"{label} has a number beyond all bounds", "give a smaller one") from None


def _flag(entry: Mapping[str, Any], key: str, label: str) -> bool | None:
    flag = entry.get(key)
    if flag is not None and not isinstance(flag, bool):
        raise InputError(key, f"{label} has {_as_json(flag)}", "give true or false")
    return flag


def _as_json(content: object) -> str:
    """What stands in the file, short; lists and objects only by kind, since they may be deep."""
    if isinstance(content, list | dict):
        return "a list" if isinstance(content, list) else "an object"
    return shown(json.dumps(content, ensure_ascii=False))
