"""The look that all figures share, and how a figure becomes files."""

import base64
import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, ClassVar

import matplotlib
from matplotlib.figure import Figure

TRUE_COLOUR = "#475569"
LEARNED_COLOUR = "#2563eb"
TEXT_COLOUR = "#0f172a"
FAINT_COLOUR = "#64748b"
LINE_COLOUR = "#cbd5e1"
ALARM_COLOUR = "#dc2626"
SHIELD_COLOUR = "#0f766e"

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
    # Names of nodes are the user's: a dollar sign in one starts no formula.
    "text.parse_math": False,
    "xtick.color": FAINT_COLOUR,
    "ytick.color": FAINT_COLOUR,
}


@dataclass(frozen=True)
class Picture:
    """A figure as the contents of two files."""

    kind: ClassVar = "drawing"
    png: bytes
    svg: bytes

    @property
    def files(self) -> dict[str, bytes]:
        """Contents by the ending of the file's name."""
        return {"png": self.png, "svg": self.svg}

    @property
    def address(self) -> str:
        """The figure itself as an address, so that a page needs no other file."""
        return "data:image/svg+xml;base64," + base64.b64encode(self.svg).decode()


@contextmanager
def figure_style() -> Iterator[None]:
    """Matplotlib's own defaults with this style on top, whatever the user has set; restored afterwards."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        with matplotlib.rc_context(STYLE):
            yield


def picture(figure: Figure) -> Picture:
    """The same figure gives the same bytes: no date, no version of the drawing library."""
    png, svg = io.BytesIO(), io.StringIO()
    figure.savefig(png, format="png", metadata={"Software": None})
    figure.savefig(svg, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    # The document type names an external address and is of no use to a browser.
    text = svg.getvalue()
    return Picture(png.getvalue(), text[text.index("<svg") :].encode())
