"""The page: one HTML file that needs nothing else, and its table as Markdown."""

from dataclasses import dataclass

from gsiirl.report.comparison_table import ComparisonRow
from gsiirl.report.experiment import experiment_words
from gsiirl.report.group import GameGroup
from gsiirl.report.page_figure import PageFigure
from gsiirl.report.paper_results import PAPER_RESULTS
from gsiirl.report.quality_table import QualityRow
from gsiirl.report.rendering import render
from gsiirl.report.table_1 import Table1
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
    def paper_note(self) -> str:
        """How far the paper's figures can be compared with these."""
        return PAPER_RESULTS[self.group.experiment].note if self.has_paper else ""

    @property
    def side_headings(self) -> tuple[str, str]:
        """What the two sides are called in tables."""
        learner, expert = (side.name for side in self.group.sides)
        return (learner, expert) if learner == "learner" else (f"{learner} (learner)", f"{expert} (expert)")


def render_page(sections: list[Section], table_1: Table1 | None, theories: list[TheoryPart]) -> str:
    """`index.html`."""
    return render(
        "page.html",
        generator=GENERATOR,
        sections=sections,
        here=_who_is_who(sections),
        table_1=table_1,
        theories=theories,
    )


def render_markdown(sections: list[Section], table_1: Table1 | None, theories: list[TheoryPart]) -> str:
    """`table.md`."""
    return render("table.md", sections=sections, table_1=table_1, theories=theories)


def _who_is_who(sections: list[Section]) -> list[tuple[str, str]]:
    """Who learner and expert are in each experiment of the page, as far as it is known."""
    words = [experiment_words(section.group.experiment).here for section in sections]
    return list(dict.fromkeys(here for here in words if here is not None))
