"""The content of a report, as HTML, Markdown and JSON."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from gsiirl.report.figures.page_figure import PageFigure
from gsiirl.report.output.chart_program import chart_program_for
from gsiirl.report.output.rendering import render
from gsiirl.report.page.notes import notes, warnings
from gsiirl.report.page.takeaways import gain_note, takeaways
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.made import MadeGroup
from gsiirl.report.read.verdict import RULE
from gsiirl.report.security.network_table import NetworkTable
from gsiirl.report.tables.comparison import RETURNS_NOTE, ComparisonRow
from gsiirl.report.tables.paper_results import paper_results
from gsiirl.report.tables.quality import METRICS, QualityRow, used_metrics
from gsiirl.report.tables.rivals import Rivals
from gsiirl.report.tables.table_1 import Table1
from gsiirl.report.theory.part import TheoryPart
from gsiirl.report.words.experiments import experiment_words
from gsiirl.runs.files.json_file import versioned

GENERATOR = "gsiirl report"


@dataclass(frozen=True)
class Section:
    """One game: its runs, sentences, tables and figures."""

    group: GameGroup
    rivals: Rivals | None
    comparison: list[ComparisonRow]
    quality: list[QualityRow]
    figures: list[PageFigure]
    network: NetworkTable | None

    @cached_property
    def takeaways(self) -> list[str]:
        """What a reader should take away."""
        return takeaways(self.group, self.rivals)

    @cached_property
    def warnings(self) -> list[str]:
        """Failed seeds and the like."""
        return warnings(self.group)

    @cached_property
    def notes(self) -> list[str]:
        """What else there is to tell."""
        return notes(self.group)

    @property
    def has_paper(self) -> bool:
        """Whether the paper has results of the game's experiment."""
        return any(row.paper is not None for row in self.comparison)

    @property
    def paper_note(self) -> str:
        """How far the paper's results can be compared with ours; empty where it has none."""
        paper = paper_results(self.group)
        return "" if paper is None or not self.has_paper else paper.note

    @property
    def side_headings(self) -> tuple[str, str]:
        """Headings of the two sides in tables."""
        learner, expert = (side.name for side in self.group.sides)
        return (learner, expert) if learner == "learner" else (f"{learner} (learner)", f"{expert} (expert)")

    @property
    def gain_note(self) -> str:
        """What shares of the gain are measured by."""
        return gain_note(self.group, self.rivals)

    def json(self) -> dict[str, Any]:
        """The entry in `table.json`."""
        return {
            "experiment": self.group.experiment,
            "game": self.group.game.get("name"),
            "variant": self.group.game.get("variant"),
            "takeaways": self.takeaways,
            "warnings": self.warnings,
            "notes": self.notes,
            **({"rivals": self.rivals.json()} if self.rivals else {}),
            "returns": [row.json() for row in self.comparison],
            "quality": [row.json() for row in self.quality],
        }


@dataclass(frozen=True)
class Report:
    """The sections of all games and the parts of all findings."""

    sections: list[Section]
    theories: list[TheoryPart]

    @cached_property
    def table_1(self) -> Table1 | None:
        """The paper's Table 1, where at least two of its experiments are there."""
        return Table1.of([(section.group, section.comparison) for section in self.sections])

    @property
    def figure_files(self) -> dict[str, bytes]:
        """Contents of all figures by file name."""
        figures = [figure for part in (*self.sections, *self.theories) for figure in part.figures]
        return {name: content for figure in figures for name, content in figure.files.items()}

    def html(self) -> str:
        """The content of `index.html`."""
        words = [experiment_words(section.group.experiment).here for section in self.sections]
        here = list(dict.fromkeys(each for each in words if each is not None))
        program = chart_program_for(figure for part in (*self.sections, *self.theories) for figure in part.figures)
        return self._render("page.html", generator=GENERATOR, here=here, program=program)

    def markdown(self) -> str:
        """The content of `table.md`."""
        return self._render("table.md")

    def json(self, files: list[str]) -> dict[str, Any]:
        """The content of `table.json`; `files` are the names of all files of the report."""
        notes = dict.fromkeys(section.paper_note for section in self.sections if section.paper_note)
        return versioned(
            {
                "generator": GENERATOR,
                "files": files,
                "notes": [RETURNS_NOTE, *notes],
                **({"table_1": self.table_1.json()} if self.table_1 else {}),
                "groups": [section.json() for section in self.sections],
                "theory": [part.findings.json() for part in self.theories],
            }
        )

    @property
    def _made_groups(self) -> list[MadeGroup]:
        several = len(self.sections) > 1
        groups = [section.group for section in self.sections]
        return [
            MadeGroup(group.title if several else "", {label: run.made for label, run in group.runs.items()})
            for group in groups
        ]

    def _render(self, template: str, **values: Any) -> str:
        values |= {"made_groups": self._made_groups, "made_lines": [part.made for part in self.theories]}
        values |= {"sections": self.sections, "theories": self.theories, "table_1": self.table_1}
        return render(
            template, metrics=METRICS, returns_note=RETURNS_NOTE, used_metrics=used_metrics, rule=RULE, **values
        )
