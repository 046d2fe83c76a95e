"""The table of final returns, ours beside the paper's."""

from dataclasses import dataclass
from typing import Any

from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.group import GameGroup
from gsiirl.report.tables.paper_results import Returns, paper_results
from gsiirl.report.words.algorithms import algorithm_style

RETURNS_NOTE = (
    "Returns are undiscounted sums under the true rewards, mean ± standard deviation over seeds; higher is better for "
    "the side they belong to."
)
SIDES = ("learner", "expert")

Evaluations = dict[str, dict[str, Estimate | None]]
"""Final returns by side and evaluation (`model`, `deployed`)."""


@dataclass(frozen=True)
class ComparisonRow:
    """The final returns of one algorithm."""

    label: str
    algorithm: str
    returns: Evaluations
    paper: Returns | None
    source: str
    """Where the returns come from, in words."""

    def json(self) -> dict[str, Any]:
        """The entry in `table.json`; what the algorithm does not have is absent."""
        content: dict[str, Any] = {"label": self.label, "algorithm": self.algorithm, "source": self.source}
        for side, evaluations in self.returns.items():
            content[side] = {name: each.json() for name, each in evaluations.items() if each is not None}
            if self.paper is not None:
                content[side]["paper"] = dict(zip(("mean", "std"), self.paper[side], strict=True))
        return content


def compare(group: GameGroup) -> list[ComparisonRow]:
    """A row for each run, and a first one for MARL, from `truth_return_*`, where MARL has no run of its own."""
    rows: list[ComparisonRow] = []
    if not any(run.algorithm == "marl" for run in group.runs.values()):
        rows += _marl_from_truth(group)
    for label, run in group.runs.items():
        returns: Evaluations = {
            side: {kind: run.estimate(f"{kind}_return_{side}") for kind in ("model", "deployed")} for side in SIDES
        }
        if run.given_the_rewards:
            for side, evaluations in returns.items():
                # MARL knows the true rewards, so its model is right: one evaluation stands for a missing one.
                known = evaluations["deployed"] or run.estimate(f"truth_return_{side}")
                returns[side] = {kind: each or known for kind, each in evaluations.items()}
        rows.append(_row(group, label, run.algorithm, returns, f"run {run.path.name}"))
    return rows


def _marl_from_truth(group: GameGroup) -> list[ComparisonRow]:
    """MARL as the first run that solved the game with the true rewards holds it; [] where none did."""
    for label, run in group.learners.items():
        truth = {side: run.estimate(f"truth_return_{side}") for side in SIDES}
        if any(truth.values()):
            returns: Evaluations = {side: dict.fromkeys(("model", "deployed"), each) for side, each in truth.items()}
            name = algorithm_style("marl").name
            return [_row(group, name, "marl", returns, f"true rewards, as solved in the run of {label}")]
    return []


def _row(group: GameGroup, label: str, algorithm: str, returns: Evaluations, source: str) -> ComparisonRow:
    paper = paper_results(group)
    return ComparisonRow(label, algorithm, returns, paper.returns.get(algorithm) if paper else None, source)
