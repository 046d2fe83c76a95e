"""A figure on a page."""

from dataclasses import dataclass

from matplotlib.figure import Figure

from gsiirl.report.figures.picture import Picture, picture


@dataclass(frozen=True)
class PageFigure:
    """A figure with the words around it."""

    name: str
    """Name for files, unique on a page."""
    heading: str
    caption: str
    alternative: str
    """The figure in words, for readers who cannot see it."""
    picture: Picture

    @property
    def files(self) -> dict[str, bytes]:
        """Contents of its files by their names in the page's folder."""
        return {f"figures/{self.name}.{ending}": content for ending, content in self.picture.files.items()}


def page_figure(
    name: str, heading: str, caption: str, alternative: str, figure: Figure | Picture | None
) -> PageFigure | None:
    """A figure with its words, or None where there is no figure."""
    if figure is None:
        return None
    return PageFigure(name, heading, caption, alternative, picture(figure) if isinstance(figure, Figure) else figure)
