"""Runs of the same game, to be compared with each other."""

import json
from dataclasses import dataclass
from typing import Any

from gsiirl.report.algorithm import algorithm_rank, algorithm_style
from gsiirl.report.experiment import VARIANTS, ExperimentWords, SideName, experiment_words
from gsiirl.report.run import ReportedRun


@dataclass(frozen=True)
class GameGroup:
    """Runs of one game, in the report's order, with a label each."""

    key: str
    """Name for files, unique in a report."""
    runs: dict[str, ReportedRun]
    """Runs by label."""

    @property
    def first(self) -> ReportedRun:
        """The run that stands first."""
        return next(iter(self.runs.values()))

    @property
    def game(self) -> dict[str, Any]:
        """The game that all runs share."""
        return self.first.game

    @property
    def experiment(self) -> str:
        """The experiment that all runs share."""
        return self.first.experiment

    @property
    def words(self) -> ExperimentWords:
        """The experiment in words."""
        return experiment_words(self.experiment)

    @property
    def title(self) -> str:
        """The game's name."""
        return f"{self.words.title}: {self.game.get('name', 'unnamed game')}"

    @property
    def variant(self) -> str:
        """The game's variant in words."""
        name = str(self.game.get("variant", ""))
        return VARIANTS.get(name, name)

    @property
    def sides(self) -> tuple[SideName, SideName]:
        """What learner and expert are called in this experiment."""
        return self.words.learner, self.words.expert

    @property
    def learners(self) -> dict[str, ReportedRun]:
        """The runs that learn rewards."""
        return {label: run for label, run in self.runs.items() if not run.given_the_rewards}

    @property
    def exploring(self) -> str:
        """A sentence for captions of what was lived through, where a run explores; else nothing."""
        names = [label for label, run in self.learners.items() if run.explores]
        return f" Encounters that {' and '.join(names)} plays to see more, not to earn, are left out." if names else ""

    def of(self, algorithm: str) -> ReportedRun | None:
        """The first run of an algorithm that has a seed left, or None."""
        matching = [run for run in self.runs.values() if run.algorithm == algorithm and run.kept_seeds]
        return matching[0] if matching else None

    def reference(self, metric: str) -> float | None:
        """What MARL (`truth_...`) or random play (`random_...`) comes to, from the first run that holds it."""
        for run in self.runs.values():
            # MARL by another solver is a line of its own.
            estimate = None if run.algorithm == "marl-maddpg" else run.estimate(metric)
            if estimate is not None:
                return estimate.mean
        return None


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
