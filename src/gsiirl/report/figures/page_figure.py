"""A figure on a page, and its files."""

import base64
import io
from dataclasses import dataclass
from urllib.parse import quote

from matplotlib.figure import Figure

from gsiirl.report.figures.charts import Charts

PLAIN = " /=:;,.()-+!*@_"
"""What stands in a `data:` address of a page as it is, besides letters and digits."""


@dataclass(frozen=True)
class PageFigure:
    """A figure with the words around it."""

    name: str
    """Name for files, unique on a page."""
    heading: str
    caption: str
    alternative: str
    """The figure in words, for readers who cannot see it."""
    contents: dict[str, bytes]
    """Its files by their endings; the last stands on the page. One that moves begins with a still picture."""
    charts: Charts | None = None
    """The same panels as charts, where there are any; a page shows them in place of the drawing where it can."""

    @property
    def files(self) -> dict[str, bytes]:
        """Contents of its files by their names in the page's folder."""
        return {f"figures/{self.name}.{ending}": content for ending, content in self.contents.items()}

    @property
    def kind(self) -> str:
        """`drawing` or `animation`: the class of the page's `img`."""
        return "animation" if "gif" in self.contents else "drawing"

    @property
    def address(self) -> str:
        """The figure as a `data:` address, so that a page needs no other file."""
        return _address(*list(self.contents.items())[-1])

    @property
    def still_address(self) -> str:
        """The same of its first file: one that moves, standing still."""
        return _address(*next(iter(self.contents.items())))


def _address(ending: str, content: bytes) -> str:
    if ending == "svg":
        # Shorter by a quarter than in base 64.
        return f"data:image/svg+xml,{quote(' '.join(content.decode().split()), safe=PLAIN)}"
    return f"data:image/{ending};base64,{base64.b64encode(content).decode()}"


def page_figure(
    name: str,
    heading: str,
    caption: str,
    alternative: str,
    figure: Figure | dict[str, bytes] | None,
    charts: Charts | None = None,
) -> PageFigure | None:
    """A drawn figure or the files of one, with its words; None where there is no figure."""
    if figure is None:
        return None
    contents = figure_files(figure) if isinstance(figure, Figure) else figure
    return PageFigure(name, heading, caption, alternative, contents, charts)


def figure_files(figure: Figure) -> dict[str, bytes]:
    """The figure as `png` and `svg`, without date and version: the same figure gives the same bytes."""
    png, svg = io.BytesIO(), io.StringIO()
    figure.savefig(png, format="png", metadata={"Software": None})
    figure.savefig(svg, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    # The document type names an external address and is of no use to a browser.
    text = svg.getvalue()
    return {"png": png.getvalue(), "svg": text[text.index("<svg") :].encode()}
