"""Final returns of every algorithm beside the paper's (its Table 1, column CS)."""

from dataclasses import dataclass
from typing import Any

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.estimate import Estimate
from gsiirl.report.group import GameGroup

PAPER_RETURNS: dict[str, dict[str, tuple[float, float]]] = {
    "marl": {"learner": (-16.96, 1.45), "expert": (6.96, 1.45)},
    "ma-irl": {"learner": (-17.08, 3.21), "expert": (7.03, 3.21)},
    "gsiirl": {"learner": (-17.38, 3.59), "expert": (6.76, 3.59)},
    "paper": {"learner": (-17.38, 3.59), "expert": (6.76, 3.59)},
}
"""Mean and standard deviation as printed in the paper's Table 1, cyber security."""

RETURNS_NOTE = (
    "Returns are undiscounted sums under the true rewards, mean ± standard deviation over seeds; higher is better for "
    "the side they belong to."
)
PAPER_NOTE = (
    "The paper's graph is not published, so its figures (Table 1, cyber security) stand here for orientation: they "
    "cannot be compared digit by digit."
)


@dataclass(frozen=True)
class ComparisonRow:
    """One algorithm's final returns, by side and evaluation (`model`, `deployed`)."""

    label: str
    algorithm: str
    returns: dict[str, dict[str, Estimate | None]]
    paper: dict[str, tuple[float, float]] | None
    source: str
    """Where the figures come from, in words."""

    def json(self) -> dict[str, Any]:
        """As it stands in `table.json`; what does not apply is absent."""
        content: dict[str, Any] = {"label": self.label, "algorithm": self.algorithm, "source": self.source}
        for side, evaluations in self.returns.items():
            content[side] = {name: each.json() for name, each in evaluations.items() if each is not None}
            if self.paper is not None:
                mean, std = self.paper[side]
                content[side]["paper"] = {"mean": mean, "std": std}
        return content


def compare(group: GameGroup) -> list[ComparisonRow]:
    """One row a run, and one for MARL from `truth_return_*` where no run of it is there."""
    rows: list[ComparisonRow] = []
    if not any(run.algorithm == "marl" for run in group.runs.values()):
        rows += _marl_from_truth(group)
    for label, run in group.runs.items():
        returns = {
            side: {kind: run.estimate(f"{kind}_return_{side}") for kind in ("model", "deployed")}
            for side in ("learner", "expert")
        }
        if run.algorithm == "marl":
            for side, evaluations in returns.items():
                truth = run.estimate(f"truth_return_{side}")
                returns[side] = {kind: each or truth for kind, each in evaluations.items()}
        rows.append(_row(group, label, run.algorithm, returns, f"run {run.path.name}"))
    return rows


def _marl_from_truth(group: GameGroup) -> list[ComparisonRow]:
    for label, run in group.runs.items():
        truth = {side: run.estimate(f"truth_return_{side}") for side in ("learner", "expert")}
        if any(truth.values()):
            # Who knows the true rewards has no model to differ from them: both evaluations are one.
            returns: dict[str, dict[str, Estimate | None]] = {
                side: {"model": each, "deployed": each} for side, each in truth.items()
            }
            name = algorithm_style("marl").name
            return [_row(group, name, "marl", returns, f"true rewards, as solved in the run of {label}")]
    return []


def _row(
    group: GameGroup, label: str, algorithm: str, returns: dict[str, dict[str, Estimate | None]], source: str
) -> ComparisonRow:
    paper = PAPER_RETURNS.get(algorithm) if group.experiment == "security" else None
    return ComparisonRow(label, algorithm, returns, paper, source)
