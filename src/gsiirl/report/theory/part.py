"""The findings of `gsiirl theory` as a part of a page."""

import re
from dataclasses import dataclass

from gsiirl.report.figures.page_figure import PageFigure, page_figure
from gsiirl.report.figures.style import figure_style
from gsiirl.report.read.made import NOT_RECORDED
from gsiirl.report.theory.finding_charts import finding_charts
from gsiirl.report.theory.finding_figure import draw_finding, straight_slope, undrawn_points
from gsiirl.runs.findings import Finding, Findings, Measurement


@dataclass(frozen=True)
class TheoryItem:
    """One finding with its figure."""

    finding: Finding
    anchor: str
    figure: PageFigure | None

    @property
    def bounded(self) -> list[Measurement]:
        """The measurements that can hold or miss."""
        return [each for each in self.finding.measurements if each.holds is not None]

    @property
    def held(self) -> int:
        """Number of bounds that hold."""
        return len(self.bounded) - len(self.finding.missed)

    @property
    def summary(self) -> str:
        """The first sentence of the claim."""
        return re.split(r"(?<=\.)\s", self.finding.claim, maxsplit=1)[0]


@dataclass(frozen=True)
class TheoryPart:
    """All findings of one folder."""

    findings: Findings
    name: str
    """Unique on its page."""
    items: list[TheoryItem]

    @classmethod
    def of(cls, findings: Findings, name: str, figure_prefix: str) -> "TheoryPart":
        """The part for `findings`, with its figures; the names of their files begin with `figure_prefix`."""
        with figure_style():
            items = [
                TheoryItem(each, f"{name}-{each.key}", _figure(each, figure_prefix + each.key))
                for each in findings.findings
            ]
        return cls(findings, name, items)

    @property
    def figures(self) -> list[PageFigure]:
        """The figures of all findings."""
        return [item.figure for item in self.items if item.figure is not None]

    @property
    def verdict(self) -> str:
        """The result in one sentence."""
        bounded, held = sum(len(item.bounded) for item in self.items), sum(item.held for item in self.items)
        if held < bounded:
            missed = [item.finding.title for item in self.items if not item.finding.holds]
            return f"{held} of {bounded} bounds hold; missed in {', '.join(missed)}."
        if self.findings.missing:
            return f"All {bounded} bounds measured so far hold; not every check was run."
        return f"All {bounded} bounds hold."

    @property
    def made(self) -> str:
        """Version, command, settings and date in one sentence."""
        environment = dict(self.findings.environment)
        date = environment.pop("date", NOT_RECORDED)
        versions = ", ".join(f"{name} {version}" for name, version in environment.items())
        quick = " --quick" if self.findings.quick else ""
        return (
            f"The theory was measured with gsiirl theory{quick} --out theory, {date}, by {versions}; games, seeds and "
            "settings of every check are fixed in the program."
        )

    @property
    def notes(self) -> list[str]:
        """Sentences about quick mode and missing checks."""
        notes = []
        if self.findings.quick:
            notes.append(
                "This is the quick mode: fewer games, points and combinations, the same claims and the same bounds."
            )
        if self.findings.missing:
            notes.append(f"Not run yet: {', '.join(self.findings.missing)}.")
        return notes


def _figure(finding: Finding, name: str) -> PageFigure | None:
    notes = []
    if any(straight_slope(panel, curve) is not None for panel in finding.panels for curve in panel.curves):
        notes.append("A slope is fitted to all points of a curve; a bent curve has none.")
    if undrawn := undrawn_points(finding):
        notes.append(f"{undrawn} points are not drawn: not finite, or not above 0 on a logarithmic axis.")
    caption = " ".join(notes)
    alternative = "; ".join(f"{panel.title}: {panel.y_label} against {panel.x_label}" for panel in finding.panels)
    return page_figure(name, finding.title, caption, alternative, draw_finding(finding), finding_charts(finding))
