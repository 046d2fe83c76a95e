"""Networks in GraphML, as networkx, yEd, Gephi, igraph and others write it.

Only the attributes that we use are looked at. What would be lost in silence (a graph inside a node, a second graph, a
hyperedge) is refused.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from gsiirl.errors import InputError
from gsiirl.scenarios.file_content import EDGE, NODE, FileContent, Kind, ListedEdge, ListedNode, edge_label
from gsiirl.scenarios.network import shown

NAMESPACE = "http://graphml.graphdrawing.org/xmlns"

WHOLE, DECIMAL = ("int", "integer", "long"), ("float", "double")
TRUTHS = {"true": True, "1": True, "false": False, "0": False}
"""Truths of XML."""

ENTITY = re.compile(rb"&(?!amp;|lt;|gt;|quot;|apos;|#)")


def read_graphml(content: bytes) -> FileContent:
    """What the file lists.

    Raises:
        InputError: when it is no GraphML, holds what we cannot read, or an attribute is of the wrong type.
    """
    root = _parse(content)
    if root.tag != "graphml":
        namespace, _, tag = root.tag.rpartition("}")
        if tag == "graphml":
            raise InputError("graphml", f"has the namespace '{shown(namespace)}'", f'give xmlns="{NAMESPACE}"')
        raise InputError("file", f"is no GraphML: it begins with <{shown(tag)}>", "give <graphml> with a <graph>")
    inside = _inside(root, "key", "graph", "data", "desc", of="the file")
    graphs = [child for child in inside if child.tag == "graph"]
    if not graphs:
        raise InputError("graph", "there is no <graph>", "put the nodes and edges into one")
    if len(graphs) > 1:
        raise InputError("graph", f"there are {len(graphs)} graphs", "keep one graph a file")
    # Some programs declare their keys in the graph.
    return _Reader([_Key.of(key) for key in (*inside, *graphs[0]) if key.tag == "key"]).read(graphs[0])


def _parse(content: bytes) -> Element:
    """The elements as a tree; names are without the namespace of GraphML, and with every other one.

    No entity may be declared, so that none is expanded and none is fetched.
    """
    builder = TreeBuilder()
    parser = expat.ParserCreate(namespace_separator="}")
    parser.buffer_text = True
    dtds: list[str | None] = []
    parser.EntityDeclHandler = _refuse_entity
    parser.StartDoctypeDeclHandler = lambda _name, file, *_: dtds.append(file)
    parser.StartElementHandler = lambda tag, attributes: builder.start(tag.removeprefix(NAMESPACE + "}"), attributes)
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, LookupError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        mend = "mend it, or save it as GraphML again, in UTF-8"
        raise InputError("file", f"is not XML ({shown(str(error), 100)})", mend) from None
    # Where a DTD of another file might declare it, the parser drops an unknown entity in silence.
    if any(dtds) and ENTITY.search(content.replace(b"\0", b"")):
        raise InputError("file", "uses XML entities of another file", "write their text in their place")
    return builder.close()


def _refuse_entity(name: str, *_: object) -> None:
    raise InputError("file", f"declares the XML entity '{shown(name)}'", "write its text in its place")


def _inside(element: Element, *known: str, of: str) -> list[Element]:
    """The element's own children; those of other namespaces are extensions, which we may leave out."""
    own = [child for child in element if "}" not in child.tag]
    for child in own:
        if child.tag not in known:
            raise InputError("file", f"{of} holds an element <{shown(child.tag)}>", f"give one of {', '.join(known)}")
    return own


@dataclass(frozen=True)
class _Key:
    """The declaration of an attribute."""

    identifier: str | None
    name: str | None
    """None for an extension of some program."""
    domain: str
    """Of what: `node`, `edge`, `all` or another."""
    type: str
    default: str | None

    @classmethod
    def of(cls, key: Element) -> "_Key":
        identifier, name = key.get("id"), key.get("attr.name")
        label = f"key '{shown(identifier or '')}'"
        # Programs mark extensions by attributes of their own: yfiles.type.
        if name is None and set(key.keys()) <= {"id", "for", "attr.type"}:
            raise InputError("key", f"{label} has no attr.name", "give it one, or remove it")
        defaults = [child for child in key if child.tag == "default"]
        if len(defaults) > 1:
            raise InputError("key", f"{label} has {len(defaults)} defaults", "keep one")
        default = (defaults[0].text or "").strip() if defaults else ""
        return cls(identifier, name, key.get("for", "all"), key.get("attr.type", "string"), default or None)

    def fits(self, kind: Kind) -> bool:
        """Whether it is declared for elements of this kind."""
        return self.domain in (kind.word, "all")

    def read(self, text: str, label: str) -> float | bool | str:
        """What a text stands for."""
        assert self.name is not None
        text = text.strip()
        if self.name == "name":
            return text
        flag = self.name in NODE.flags
        wanted = 'true or false, with attr.type="boolean"' if flag else 'a number, with attr.type="double"'
        if not text:
            raise InputError(self.name, f"{label} has an empty one", f"give {wanted}, or remove the element")
        if self.type not in (("boolean",) if flag else WHOLE + DECIMAL):
            problem = f"{label} has '{shown(text)}' of the type {shown(self.type)}"
            raise InputError(self.name, problem, f"give {wanted} in its <key>")
        try:
            if flag:
                return TRUTHS[text.lower()]
            if "_" in text:
                raise ValueError("Python's, not XML's")
            return float(int(text) if self.type in WHOLE else float(text))
        except (KeyError, ValueError, OverflowError):
            mend = "give true or false" if flag else "give a number"
            if not flag and self.type in WHOLE:
                mend = 'give a whole number, or attr.type="double" in its <key>'
            raise InputError(self.name, f"{label} has '{shown(text)}'", mend) from None


class _Reader:
    """Collects the nodes and edges of one graph, by the keys that its file declares."""

    def __init__(self, keys: Sequence[_Key]) -> None:
        self.keys: dict[Kind, dict[str, _Key]] = {NODE: {}, EDGE: {}}
        declared: set[tuple[str, str]] = set()
        for key in keys:
            if key.identifier is None:
                continue
            if (key.identifier, key.domain) in declared:
                raise InputError("key", f"key '{shown(key.identifier)}' is there twice", "keep one of the two")
            declared.add((key.identifier, key.domain))
            for kind, known in self.keys.items():
                # Programs give one id to a key of nodes and another of edges.
                if key.identifier not in known or key.fits(kind):
                    known[key.identifier] = key
        self.content = FileContent()
        self.defaults = {kind: self._defaults(keys, kind) for kind in (NODE, EDGE)}

    def _defaults(self, keys: Sequence[_Key], kind: Kind) -> Mapping[str, Any]:
        defaults: dict[str, Any] = {}
        for name in kind.attributes:
            own = [key for key in keys if key.name == name]
            fitting = [key for key in own if key.fits(kind)]
            if not fitting and name != "name":
                fitting = [key for key in own if key.domain in (NODE.word, EDGE.word)]
            for key in fitting:
                if key.default is None:
                    continue
                label = f"key '{shown(key.identifier or '')}'"
                if name in defaults:
                    raise InputError(name, f"{label} has a second default", "keep one of them")
                defaults[name] = key.read(key.default, f"{label} in its default")
                if not key.fits(kind):
                    self.content.notes.append(f'{label} is read as if it had for="{kind.word}", as {name} needs')
        self.content.attribute_names[kind] |= {key.name for key in keys if key.name and key.default and key.fits(kind)}
        return defaults

    def read(self, graph: Element) -> FileContent:
        """All of the graph, and of the groups in it, in the order of the file."""
        pending = self._elements(graph, "the graph", directed=False)
        while pending:
            element, directed = pending.pop()
            if element.tag == "node":
                pending += self._node(element, directed)
            elif element.tag == "edge":
                self._edge(element, directed)
            elif element.tag == "hyperedge":
                ends = ", ".join(f"'{shown(end.get('node', ''))}'" for end in element if end.tag == "endpoint")
                raise InputError(
                    "hyperedge", f"one joins {shown(ends)}", "write an edge for each pair that can be attacked"
                )
        return self.content

    def _elements(self, graph: Element, label: str, directed: bool) -> list[tuple[Element, bool]]:
        """The elements of a graph, last first, and whether its edges are directed if they do not say so themselves."""
        given = graph.get("edgedefault", "").strip().lower()
        if given not in ("directed", "undirected", ""):
            raise InputError("edgedefault", f"{label} has '{shown(given)}'", "give directed or undirected")
        directed = given == "directed" if given else directed
        known = _inside(graph, "node", "edge", "hyperedge", "key", "data", "desc", of=label)
        return [(element, directed) for element in reversed(known)]

    def _node(self, node: Element, directed: bool) -> list[tuple[Element, bool]]:
        """Note the node; of a group, which a drawing has around some nodes, hand out what is in it."""
        identifier = node.get("id")
        if identifier is None:
            raise InputError("nodes", f"node number {len(self.content.nodes) + 1} has no id", "give it an id")
        label = f"node '{shown(identifier)}'"
        inside = _inside(node, "data", "graph", "port", "desc", of=label)
        graphs = [child for child in inside if child.tag == "graph"]
        if node.get("yfiles.foldertype") is not None:
            names = {key.name for data in inside if (key := self.keys[NODE].get(data.get("key", "")))}
            self.content.groups[identifier] = [name for name in NODE.numbers + NODE.flags if name in names]
            return [
                pair for graph in reversed(graphs) for pair in self._elements(graph, f"the graph of {label}", directed)
            ]
        if graphs:
            raise InputError("nodes", f"{label} holds a graph", "move its nodes and edges into the one graph")
        shown_label, attributes = self._attributes(inside, NODE, label)
        self.content.nodes.append(ListedNode(identifier, attributes, shown_label))
        return []

    def _edge(self, edge: Element, directed: bool) -> None:
        source, target = edge.get("source"), edge.get("target")
        if source is None or target is None:
            lacking, (end, other) = ("target", ("from", source)) if source else ("source", ("to", target))
            number = f"edge number {len(self.content.edges) + 1}, {end} '{shown(other or '')}',"
            raise InputError("edges", f"{number} has no {lacking}", "name a node")
        label = edge_label(source, target)
        own = edge.get("directed")
        if own is not None:
            if own.strip().lower() not in TRUTHS:
                raise InputError("directed", f"{label} has '{shown(own)}'", "give true or false")
            directed = TRUTHS[own.strip().lower()]
        elif directed:
            directed = not _drawn_alike_at_both_ends(edge)
        _, attributes = self._attributes(_inside(edge, "data", "desc", of=label), EDGE, label)
        self.content.edges.append(ListedEdge(source, target, directed, attributes))

    def _attributes(self, children: Sequence[Element], kind: Kind, label: str) -> tuple[str | None, Mapping[str, Any]]:
        """The label that drawing programs show, and those attributes that we use."""
        found: dict[str, Any] = {}
        shown_label = drawn_label = None
        for data in (child for child in children if child.tag == "data"):
            identifier = data.get("key")
            if identifier is None:
                raise InputError("data", f"{label} has data without a key", "name the <key>, or remove the data")
            key = self.keys[kind].get(identifier)
            if key is None:
                problem = f"{label} has data of the key '{shown(identifier)}', which is not declared"
                raise InputError("data", problem, "add the <key>, or remove the data")
            name, text = key.name, data.text or ""
            if name is None:
                drawn_label = drawn_label or _drawn_label(data)
                continue
            self.content.attribute_names[kind].add(name)
            if name.lower() == "label":
                shown_label = text.strip()
            if name not in kind.attributes:
                continue
            if name in found:
                raise InputError(name, f"{label} has it twice", "keep one of the two")
            if len(data):
                raise InputError(name, f"{label} has other elements in it", "give a plain text")
            found[name] = key.read(text, label)
        return shown_label or drawn_label, {**self.defaults[kind], **found}


def _drawn_alike_at_both_ends(edge: Element) -> bool:
    """Whether yEd draws a line without an arrow, or with one at either end: it calls every line directed."""
    for element in edge.iter():
        if element.tag.endswith("}Arrows"):
            return (element.get("source", "none") == "none") == (element.get("target", "none") == "none")
    return False


def _drawn_label(data: Element) -> str | None:
    """The text of yEd's first label."""
    labels = (element.text or "" for element in data.iter() if element.tag.endswith("}NodeLabel"))
    return next((label for label in labels if label.strip()), None)
