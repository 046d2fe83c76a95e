"""Colours and matplotlib settings of all figures."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib

from gsiirl.report.figures.fonts import font_families

TRUE_COLOUR = "#475569"
LEARNED_COLOUR = "#2563eb"
TEXT_COLOUR = "#0f172a"
FAINT_COLOUR = "#64748b"
LINE_COLOUR = "#cbd5e1"
ALARM_COLOUR = "#dc2626"
SHIELD_COLOUR = "#0f766e"

Look = dict[str, Any]
"""Keyword arguments of matplotlib: how something is drawn."""

STYLE: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": "#94a3b8",
    "axes.grid": True,
    "axes.labelcolor": FAINT_COLOUR,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlecolor": TEXT_COLOUR,
    "axes.titlelocation": "left",
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "font.size": 10,
    "grid.color": "#e2e8f0",
    "legend.frameon": False,
    "savefig.dpi": 160,
    # Names of ids in SVG files are otherwise drawn at random.
    "svg.hashsalt": "gsiirl",
    "text.color": TEXT_COLOUR,
    # A user's name of a node may hold a dollar sign, which would start a formula.
    "text.parse_math": False,
    "xtick.color": FAINT_COLOUR,
    "ytick.color": FAINT_COLOUR,
}


@contextmanager
def figure_style() -> Iterator[None]:
    """Inside, matplotlib has its defaults and this style, whatever the user has set; afterwards the user's settings."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        families: dict[Any, Any] = {"font.family": font_families()}
        with matplotlib.rc_context(STYLE | families):
            yield
