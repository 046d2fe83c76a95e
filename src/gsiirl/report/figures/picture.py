"""A figure as files."""

import base64
import io
from dataclasses import dataclass

from matplotlib.figure import Figure


@dataclass(frozen=True)
class Picture:
    """A figure as the contents of one file or of several."""

    kind: str
    """`drawing` or `animation`: the class of the page's `img`."""
    files: dict[str, bytes]
    """Contents by file ending; the last is the one that stands on the page."""

    @property
    def address(self) -> str:
        """The picture as a `data:` address, so that a page needs no other file."""
        ending, content = list(self.files.items())[-1]
        return f"data:image/{ending.replace('svg', 'svg+xml')};base64,{base64.b64encode(content).decode()}"


def picture(figure: Figure) -> Picture:
    """The figure as PNG and SVG; the same figure gives the same bytes: no date, no version of the drawing library."""
    png, svg = io.BytesIO(), io.StringIO()
    figure.savefig(png, format="png", metadata={"Software": None})
    figure.savefig(svg, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    # The document type names an external address and is of no use to a browser.
    text = svg.getvalue()
    return Picture("drawing", {"png": png.getvalue(), "svg": text[text.index("<svg") :].encode()})
