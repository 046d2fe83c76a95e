"""A figure on a page."""

import base64
from dataclasses import dataclass

from gsiirl.report.figure_style import Picture


@dataclass(frozen=True)
class PageFigure:
    """A figure with the words around it."""

    name: str
    heading: str
    caption: str
    alternative: str
    """What it shows, for who cannot see it."""
    picture: Picture

    @property
    def address(self) -> str:
        """The figure itself as an address, so that the page needs no other file."""
        return "data:image/svg+xml;base64," + base64.b64encode(self.picture.svg).decode()

    @property
    def files(self) -> dict[str, bytes]:
        """Its files by their names in the page's folder."""
        contents = (("png", self.picture.png), ("svg", self.picture.svg))
        return {f"figures/{self.name}.{ending}": content for ending, content in contents}
