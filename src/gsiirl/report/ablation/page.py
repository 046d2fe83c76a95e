"""The page that `gsiirl ablation` writes beside its runs."""

from pathlib import Path

from gsiirl.report.ablation.figure import ablation_charts, draw_ablation
from gsiirl.report.ablation.results import AblationResults
from gsiirl.report.figures.page_figure import PageFigure, figure_files
from gsiirl.report.figures.style import figure_style
from gsiirl.report.output.chart_program import chart_program_for
from gsiirl.report.output.rendering import render
from gsiirl.report.output.writing import write_files
from gsiirl.report.read.verdict import RULE

PAGE, MARKDOWN = "index.html", "ablation.md"


def write_ablation_page(folder: Path) -> Path:
    """Write `index.html`, `ablation.md` and `figures/` into the folder of an ablation; returns the page's path.

    Raises:
        InputError: a run is missing, or `folder` cannot be written.
    """
    results = AblationResults.read(folder)
    with figure_style():
        figure = PageFigure(
            "ablation",
            "Where each variant ends",
            "Points are means over seeds, bars their 95 % intervals. The higher, the better: above the dashed line the "
            "learner earns more than MARL, which is given both true rewards. From the paper's preset on the left to "
            "the default on the right, each change on top of those before it.",
            "Deployed return of the learner less MARL's, by variant and graph",
            figure_files(draw_ablation(results)),
            ablation_charts(results),
        )
    values = {"results": results, "plan": results.plan, "figure": figure, "rule": RULE}
    values["program"] = chart_program_for([figure])
    values |= {"made_groups": [results.made], "made_lines": [f"Made by {results.command}"]}
    table = render("ablation.md", **values)
    page = render("ablation.html", generator="gsiirl ablation", **values)
    write_files(folder, {**figure.files, MARKDOWN: table.encode(), PAGE: page.encode()})
    return folder / PAGE
