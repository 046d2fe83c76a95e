"""Final returns of every algorithm beside the paper's."""

from dataclasses import dataclass
from typing import Any

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.estimate import Estimate
from gsiirl.report.group import GameGroup
from gsiirl.report.paper_results import PAPER_RESULTS, Returns

RETURNS_NOTE = (
    "Returns are undiscounted sums under the true rewards, mean ± standard deviation over seeds; higher is better for "
    "the side they belong to."
)


@dataclass(frozen=True)
class ComparisonRow:
    """One algorithm's final returns, by side and evaluation (`model`, `deployed`)."""

    label: str
    algorithm: str
    returns: dict[str, dict[str, Estimate | None]]
    paper: Returns | None
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
        if run.given_the_rewards:
            for side, evaluations in returns.items():
                # Who knows the true rewards has no model to differ from them: one evaluation stands for a missing one.
                known = evaluations["deployed"] or run.estimate(f"truth_return_{side}")
                returns[side] = {kind: each or known for kind, each in evaluations.items()}
        rows.append(_row(group, label, run.algorithm, returns, f"run {run.path.name}"))
    return rows


def _marl_from_truth(group: GameGroup) -> list[ComparisonRow]:
    for label, run in group.learners.items():
        truth = {side: run.estimate(f"truth_return_{side}") for side in ("learner", "expert")}
        if any(truth.values()):
            returns: dict[str, dict[str, Estimate | None]] = {
                side: {"model": each, "deployed": each} for side, each in truth.items()
            }
            name = algorithm_style("marl").name
            return [_row(group, name, "marl", returns, f"true rewards, as solved in the run of {label}")]
    return []


def _row(
    group: GameGroup, label: str, algorithm: str, returns: dict[str, dict[str, Estimate | None]], source: str
) -> ComparisonRow:
    paper = PAPER_RESULTS.get(group.experiment)
    return ComparisonRow(label, algorithm, returns, paper.returns.get(algorithm) if paper else None, source)
