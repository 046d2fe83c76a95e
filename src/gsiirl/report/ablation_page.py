"""The page that `gsiirl ablation` writes beside its runs."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from gsiirl.errors import InputError
from gsiirl.report.ablation_figure import draw_ablation
from gsiirl.report.ablation_results import AblationResults, Effect, VariantResult
from gsiirl.report.figure_style import figure_style, picture
from gsiirl.report.page_figure import PageFigure
from gsiirl.report.rendering import render
from gsiirl.runs import Variant
from gsiirl.runs.atomic import write_atomically

PAGE, MARKDOWN = "index.html", "ablation.md"


@dataclass(frozen=True)
class AblationRow:
    """One variant over all graphs."""

    name: str
    description: str
    cells: list[VariantResult]
    effects: list[Effect]

    @property
    def verdict(self) -> str:
        """On how many graphs the change helped."""
        counts = Counter(effect.verdict for effect in self.effects)
        return ", ".join(f"{word} on {counts[word]}" for word in ("better", "no difference", "worse") if counts[word])

    @property
    def below_random(self) -> int:
        """Seeds of all graphs that ended below random play."""
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
        InputError: a run of it is missing, or `folder` cannot be written.
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
    rows = [_row(results, each) for each in plan.variants]
    marl = [results.results[graph, plan.variants[0].name].marl for graph in plan.graphs]
    values = {"graphs": plan.graphs, "rows": rows, "marl": marl, "figure": figure}
    contents = {
        **figure.files,
        MARKDOWN: render("ablation.md", **values).encode(),
        PAGE: render("ablation.html", generator="gsiirl ablation", **values).encode(),
    }
    try:
        for name, content in contents.items():
            write_atomically(folder / name, content)
    except OSError as error:
        raise InputError("--out", f"{folder} cannot be written ({error.strerror})", "use another folder") from error
    return folder / PAGE


def _row(results: AblationResults, variant: Variant) -> AblationRow:
    cells = [results.results[graph, variant.name] for graph in results.plan.graphs]
    return AblationRow(variant.name, variant.description, cells, results.effects(variant))
