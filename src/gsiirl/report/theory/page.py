"""The page that `gsiirl theory` writes beside its numbers."""

from pathlib import Path

from gsiirl.report.output.chart_program import chart_program_for
from gsiirl.report.output.rendering import render
from gsiirl.report.output.writing import write_files
from gsiirl.report.theory.part import TheoryPart
from gsiirl.runs.findings import Findings

PAGE = "index.html"


def write_theory_page(findings: Findings, folder: Path) -> Path:
    """Write `index.html` and `figures/` into the folder of `theory.json`; returns the page's path.

    Raises:
        InputError: `folder` cannot be written.
    """
    part = TheoryPart.of(findings, "theory", "")
    contents = {name: content for figure in part.figures for name, content in figure.files.items()}
    contents[PAGE] = render(
        "theory.html",
        generator="gsiirl theory",
        theory=part,
        made_groups=[],
        made_lines=[part.made],
        program=chart_program_for(part.figures),
    ).encode()
    write_files(folder, contents)
    return folder / PAGE
