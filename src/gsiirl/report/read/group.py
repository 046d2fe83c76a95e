"""Runs of one game, which are compared with each other."""

import json
from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

from gsiirl.report.read.run import ReportedRun
from gsiirl.report.words.algorithms import algorithm_rank, algorithm_style
from gsiirl.report.words.experiments import HANDED, VARIANTS, ExperimentWords, SideName, experiment_words


@dataclass(frozen=True)
class GameGroup:
    """The runs of one game."""

    key: str
    """Name for files, unique in a report."""
    runs: dict[str, ReportedRun]
    """By label, in the report's order."""
    apart: str = ""
    """What tells it from other games of the same name in the report; empty where its name is the only one."""

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
        """The experiment's words."""
        return experiment_words(self.experiment)

    @property
    def title(self) -> str:
        """The game's name, no other's in the report."""
        name = f"{self.words.title}: {self.game.get('name', 'unnamed game')}"
        return f"{name}, {self.apart}" if self.apart else name

    @property
    def variant(self) -> str:
        """The game's variant in words."""
        name = str(self.game.get("variant", ""))
        return VARIANTS.get(name, name)

    @property
    def handed(self) -> str:
        """A sentence that says so, where the learner's own reward tells it the expert's; else empty."""
        return HANDED.get(str(self.game.get("variant", "")), "")

    @property
    def meeting(self) -> str:
        """Who meets whom, and what is not known, in a sentence."""
        learner, expert = self.sides
        one, other = self.words.here or ("a learner", "an expert")
        text = f"{one} {learner.verb('meets', 'meet')} {other}"
        if not self.handed:
            text += f", without being told what the {expert} {expert.verb('wants', 'want')}"
        return f"{text[0].upper()}{text[1:]}."

    @property
    def subject(self) -> str | None:
        """The label of the learner that all others are compared with: GSIIRL, else the first; None without any."""
        ours = (label for label, run in self.runs.items() if run.algorithm == "gsiirl")
        return next(ours, None) or next(iter(self.learners), None)

    @property
    def sides(self) -> tuple[SideName, SideName]:
        """Names of learner and expert."""
        return self.words.learner, self.words.expert

    @property
    def learners(self) -> dict[str, ReportedRun]:
        """The runs that learn rewards."""
        return {label: run for label, run in self.runs.items() if not run.given_the_rewards}

    @property
    def exploring(self) -> str:
        """A sentence for captions that says whose exploring interactions are left out; empty where no run explores."""
        names = [label for label, run in self.learners.items() if run.explores]
        return f" Encounters that {' and '.join(names)} plays to see more, not to earn, are left out." if names else ""

    def of(self, algorithm: str) -> ReportedRun | None:
        """The first run of an algorithm with a kept seed, or None."""
        return next((run for run in self.runs.values() if run.algorithm == algorithm and run.kept_seeds), None)

    def reference(self, metric: str) -> float | None:
        """Mean of a final metric of MARL (`truth_...`), random play and the like; None where no run holds it."""
        # MARL by another solver has a line of its own.
        estimates = (run.over_all_seeds(metric) for run in self.runs.values() if run.algorithm != "marl-maddpg")
        return next((each.mean for each in estimates if each is not None), None)


def group_runs(runs: list[ReportedRun]) -> list[GameGroup]:
    """Runs grouped by experiment and game, in the order in which they are given."""
    groups: dict[str, list[ReportedRun]] = {}
    for run in runs:
        groups.setdefault(json.dumps([run.experiment, run.game], sort_keys=True), []).append(run)
    return _told_apart(
        [GameGroup(f"game-{number}", _labelled(group)) for number, group in enumerate(groups.values(), start=1)]
    )


def _told_apart(groups: list[GameGroup]) -> list[GameGroup]:
    """Games of one name have their variant behind it; those of one variant as well which of how many they are."""
    named = [(group.title, str(group.game.get("variant", "")).replace("_", " ")) for group in groups]
    titles, alike = Counter(title for title, _ in named), Counter(named)
    passed: Counter[tuple[str, str]] = Counter()
    told = []
    for group, name in zip(groups, named, strict=True):
        passed[name] += 1
        place = f"{passed[name]} of {alike[name]}" if alike[name] > 1 else ""
        apart = ", ".join(filter(None, (name[1], place)))
        told.append(replace(group, apart=apart) if titles[name[0]] > 1 else group)
    return told


def _labelled(runs: list[ReportedRun]) -> dict[str, ReportedRun]:
    """Runs by the name of their algorithm; of several with one algorithm each has its folder's name in the label."""
    algorithms = [run.algorithm for run in runs]
    labelled: dict[str, ReportedRun] = {}
    alike: Counter[str] = Counter()
    for run in sorted(runs, key=lambda run: algorithm_rank(run.algorithm)):
        name = algorithm_style(run.algorithm).name
        label = name if algorithms.count(run.algorithm) == 1 else f"{name} ({run.path.name})"
        alike[label] += 1
        labelled[label if alike[label] == 1 else f"{label} {alike[label]}"] = run
    return labelled
