"""The page that `gsiirl ablation` writes beside its runs."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from gsiirl.report.ablation.figure import draw_ablation
from gsiirl.report.ablation.results import AblationResults, Effect, VariantResult
from gsiirl.report.figures.page_figure import PageFigure
from gsiirl.report.figures.picture import picture
from gsiirl.report.figures.style import figure_style
from gsiirl.report.output.rendering import render
from gsiirl.report.output.writing import write_files

PAGE, MARKDOWN = "index.html", "ablation.md"


@dataclass(frozen=True)
class AblationRow:
    """One variant on all graphs."""

    name: str
    description: str
    cells: list[VariantResult]
    """One for each graph."""
    effects: list[Effect]
    """One for each graph; none for the first variant."""

    @property
    def verdict(self) -> str:
        """On how many graphs the change helped, did nothing or harmed."""
        counts = Counter(effect.verdict for effect in self.effects)
        return ", ".join(f"{word} on {counts[word]}" for word in ("better", "no difference", "worse") if counts[word])

    @property
    def below_random(self) -> int:
        """Number of seeds, of all graphs, that ended below random play."""
        return sum(cell.below_random for cell in self.cells)

    @property
    def solves(self) -> float:
        """Games solved by one seed, mean over graphs."""
        return sum(cell.solves for cell in self.cells) / len(self.cells)

    @property
    def trajectories(self) -> float:
        """Trajectories asked for by one seed, mean over graphs."""
        return sum(cell.trajectories for cell in self.cells) / len(self.cells)


def write_ablation_page(folder: Path) -> Path:
    """Write `index.html`, `ablation.md` and `figures/` into the folder of an ablation; returns the page's path.

    Raises:
        InputError: a run is missing, or `folder` cannot be written.
    """
    results = AblationResults.read(folder)
    plan = results.plan
    with figure_style():
        figure = PageFigure(
            "ablation",
            "Where each variant ends",
            "Points are means over seeds, bars their 95 % intervals. The higher, the better: above the dashed line the "
            "learner earns more than MARL, which is given both true rewards. From the paper's preset on the left to "
            "the default on the right, each change on top of those before it.",
            "Deployed return of the learner less MARL's, by variant and graph",
            picture(draw_ablation(results)),
        )
    rows = [
        AblationRow(each.name, each.description, results.of_variant(each), results.effects(each))
        for each in plan.variants
    ]
    marl = [cell.marl for cell in results.of_variant(plan.variants[0])]
    values = {"graphs": plan.graphs, "rows": rows, "marl": marl, "figure": figure}
    table = render("ablation.md", **values)
    page = render("ablation.html", generator="gsiirl ablation", **values)
    write_files(folder, {**figure.files, MARKDOWN: table.encode(), PAGE: page.encode()})
    return folder / PAGE
