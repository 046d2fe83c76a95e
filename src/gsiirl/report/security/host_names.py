"""Names of machines as figures show them: whole where all fit, else numbered."""

import unicodedata
from dataclasses import replace

from gsiirl.report.figures.fonts import is_drawable
from gsiirl.report.security.recorded_graph import RecordedGraph

WIDEST, CUT = 17, 12
"""Widths of a whole name and of the part of a numbered one, in letters."""


def are_numbered(names: list[str]) -> bool:
    """Whether a name is too wide for a card, or has a character that no font of this machine has."""
    return any(_width(name) > WIDEST or not is_drawable(name) for name in names)


def with_short_names(graph: RecordedGraph) -> RecordedGraph:
    """The graph as figures show it; numbers count from 1, as in the table of all machines."""
    if not are_numbered(graph.nodes):
        return graph
    return replace(graph, nodes=[f"{number} {_cut(name)}".strip() for number, name in enumerate(graph.nodes, start=1)])


def _cut(name: str) -> str:
    """As much of a name as fits beside its number; nothing of one that cannot be drawn."""
    if not is_drawable(name):
        return ""
    if _width(name) <= CUT + 1:
        return name
    kept = ""
    for letter in name:
        if _width(kept + letter) > CUT:
            break
        kept += letter
    return kept + "\N{HORIZONTAL ELLIPSIS}"


def _width(text: str) -> int:
    """East Asian letters are twice as wide as others."""
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)
