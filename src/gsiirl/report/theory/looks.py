"""Colours, markers and lines of the curves of a finding."""

from gsiirl.report.figures.style import Look
from gsiirl.runs.findings import Curve, Panel


def _cycle(colours: str, markers: str, **look: object) -> list[Look]:
    """A look for each colour and marker."""
    pairs = zip(colours.split(), markers.split(), strict=True)
    return [{"color": colour, "marker": marker, "linewidth": 1.8, **look} for colour, marker in pairs]


OUR_COLOURS = "#2563eb #0d9488 #d97706 #be185d #475569 #65a30d"
PAPER_COLOURS = "#9333ea #c026d3 #6366f1 #db2777 #7e22ce #a78bfa"
LOOKS: dict[str, list[Look]] = {
    "ours": _cycle(OUR_COLOURS, "o s D ^ v P", markersize=5, zorder=4),
    "paper": _cycle(PAPER_COLOURS, "x * + 1 X p", linestyle=(0, (4, 2)), markersize=6, zorder=3),
    "guide": [{"color": "#94a3b8", "linewidth": 1.0, "linestyle": line, "zorder": 2} for line in ("--", ":", "-.")],
}
"""By role of a curve; within a role the curves are told apart by markers or lines as well as by colours."""


def curve_looks(panels: list[Panel]) -> dict[tuple[str, str], Look]:
    """Matplotlib's settings by role and name: curves of one name look the same in all panels."""
    keys = dict.fromkeys((role_of(curve), curve.name) for panel in panels for curve in panel.curves)
    numbers = dict.fromkeys(LOOKS, 0)
    looks: dict[tuple[str, str], Look] = {}
    for role, name in keys:
        looks[role, name] = LOOKS[role][numbers[role] % len(LOOKS[role])]
        numbers[role] += 1
    return looks


def role_of(curve: Curve) -> str:
    """The role of a curve; one that is not known counts as ours."""
    return curve.role if curve.role in LOOKS else "ours"
