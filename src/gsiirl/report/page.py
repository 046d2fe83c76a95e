"""The page: one HTML file that needs nothing else, and its table as Markdown."""

from dataclasses import dataclass

from gsiirl.report.comparison_table import ComparisonRow
from gsiirl.report.group import GameGroup
from gsiirl.report.page_figure import PageFigure
from gsiirl.report.quality_table import QualityRow
from gsiirl.report.rendering import render
from gsiirl.report.theory_part import TheoryPart

GENERATOR = "gsiirl report"


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


def render_page(sections: list[Section], theories: list[TheoryPart]) -> str:
    """`index.html`."""
    security = all(section.group.experiment == "security" for section in sections)
    return render("page.html", generator=GENERATOR, sections=sections, theories=theories, security=security)


def render_markdown(sections: list[Section], theories: list[TheoryPart]) -> str:
    """`table.md`."""
    return render("table.md", sections=sections, theories=theories)
