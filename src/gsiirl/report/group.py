"""Runs of the same game, to be compared with each other."""

import json
from dataclasses import dataclass
from typing import Any

from gsiirl.report.algorithm import algorithm_rank, algorithm_style
from gsiirl.report.run import ReportedRun

VARIANTS = {
    "general_sum": "general-sum: the defender's losses differ from the attacker's gains",
    "zero_sum": "the paper's variant: the defender's dependent reward is minus the attacker's reward",
}


@dataclass(frozen=True)
class GameGroup:
    """Runs of one game, in the report's order, with a label each."""

    key: str
    """Name for files, unique in a report."""
    runs: dict[str, ReportedRun]
    """Runs by label."""

    @property
    def game(self) -> dict[str, Any]:
        """The game that all runs share."""
        return next(iter(self.runs.values())).game

    @property
    def experiment(self) -> str:
        """The experiment that all runs share."""
        return next(iter(self.runs.values())).experiment

    @property
    def title(self) -> str:
        """The game's name."""
        return f"{self.experiment.capitalize()}: {self.game.get('name', 'unnamed game')}"

    @property
    def variant(self) -> str:
        """The game's variant in words."""
        name = str(self.game.get("variant", ""))
        return VARIANTS.get(name, name)

    @property
    def sides(self) -> tuple[str, str]:
        """What learner and expert are called in this experiment."""
        return ("defender", "attacker") if self.experiment == "security" else ("learner", "expert")

    def of(self, algorithm: str) -> ReportedRun | None:
        """The first run of an algorithm that has a seed left, or None."""
        matching = [run for run in self.runs.values() if run.algorithm == algorithm and run.kept_seeds]
        return matching[0] if matching else None


def group_runs(runs: list[ReportedRun]) -> list[GameGroup]:
    """Groups of the same experiment and game, in the order in which they were given."""
    groups: dict[str, list[ReportedRun]] = {}
    for run in runs:
        groups.setdefault(json.dumps([run.experiment, run.game], sort_keys=True), []).append(run)
    return [
        GameGroup(key=f"game-{number}", runs=_labelled(group)) for number, group in enumerate(groups.values(), start=1)
    ]


def _labelled(runs: list[ReportedRun]) -> dict[str, ReportedRun]:
    ordered = sorted(runs, key=lambda run: algorithm_rank(run.algorithm))
    algorithms = [run.algorithm for run in ordered]
    labelled: dict[str, ReportedRun] = {}
    for run in ordered:
        label = algorithm_style(run.algorithm).name
        if algorithms.count(run.algorithm) > 1:
            label = f"{label} ({run.path.name})"
        if label in labelled:
            label = f"{algorithm_style(run.algorithm).name} ({run.path})"
        labelled[label] = run
    return labelled
