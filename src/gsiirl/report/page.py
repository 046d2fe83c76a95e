"""The page: one HTML file that needs nothing else, and its table as Markdown."""

import base64
from dataclasses import dataclass

import jinja2

from gsiirl.report.comparison_table import PAPER_NOTE, RETURNS_NOTE, ComparisonRow
from gsiirl.report.estimate import format_number
from gsiirl.report.figure_style import Picture
from gsiirl.report.group import GameGroup
from gsiirl.report.quality_table import METRICS, QualityRow, used_metrics

GENERATOR = "gsiirl report"


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


@dataclass(frozen=True)
class Section:
    """One game: its runs, sentences, tables and figures."""

    group: GameGroup
    verdicts: list[str]
    comparison: list[ComparisonRow]
    quality: list[QualityRow]
    figures: list[PageFigure]

    @property
    def has_paper(self) -> bool:
        """Whether the paper has figures to stand beside these."""
        return any(row.paper is not None for row in self.comparison)

    @property
    def side_headings(self) -> tuple[str, str]:
        """What the two sides are called in tables."""
        learner, expert = self.group.sides
        return (learner, expert) if learner == "learner" else (f"{learner} (learner)", f"{expert} (expert)")


def render_page(sections: list[Section]) -> str:
    """`index.html`."""
    return _render("page.html", sections)


def render_markdown(sections: list[Section]) -> str:
    """`table.md`."""
    return _render("table.md", sections)


def _render(template: str, sections: list[Section]) -> str:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("gsiirl.report"),
        autoescape=jinja2.select_autoescape(["html"]),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals.update(
        generator=GENERATOR,
        metrics=METRICS,
        number=format_number,
        paper_note=PAPER_NOTE,
        returns_note=RETURNS_NOTE,
        used_metrics=used_metrics,
    )
    return environment.get_template(template).render(
        sections=sections, security=all(section.group.experiment == "security" for section in sections)
    )
