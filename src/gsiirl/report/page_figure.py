"""A figure on a page."""

from dataclasses import dataclass

from gsiirl.report.animation import Animation
from gsiirl.report.figure_style import Picture


@dataclass(frozen=True)
class PageFigure:
    """A figure with the words around it."""

    name: str
    heading: str
    caption: str
    alternative: str
    """What it shows, for who cannot see it."""
    picture: Picture | Animation

    @property
    def address(self) -> str:
        """The figure itself as an address, so that the page needs no other file."""
        return self.picture.address

    @property
    def files(self) -> dict[str, bytes]:
        """Its files by their names in the page's folder."""
        return {f"figures/{self.name}.{ending}": content for ending, content in self.picture.files.items()}
