"""The learner beside its rivals: returns, shares of what could be gained, differences and verdicts."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.read.verdict import ROUNDING, SeedValues, Verdict, judge_difference
from gsiirl.report.words.algorithms import algorithm_style
from gsiirl.report.words.numbers import format_difference, format_share

DEPLOYED = "deployed_return_learner"
ORDER = ("sharp", "marl", "marl-maddpg", "ma-irl", "lin2019", "paper")
"""Of the rivals; all other learners come after them, and random play last."""
NOTES = {
    "gsiirl": "learns by interacting",
    "ma-irl": "learns by watching alone",
    "lin2019": "learns by watching alone, one linear program",
}
"""Who learns how, for readers who do not know the names."""
DASH = "\N{EN DASH}"


@dataclass(frozen=True)
class Gain:
    """What could be gained over random play."""

    random: float
    """The learner's return of random play: nothing of it."""
    best: float
    """The return that stands for all of it."""
    is_ceiling: bool
    """Whether that is the best commitment that a search with the true reward finds; else it is MARL's, deployed."""

    def share(self, earned: float) -> float | None:
        """How much of it a return reaches; None where there is nothing to be gained."""
        span = self.best - self.random
        rounding = ROUNDING * max(abs(self.best), abs(self.random))
        return (earned - self.random) / span if span > rounding else None


@dataclass(frozen=True)
class Rival:
    """One row of the table."""

    label: str
    algorithm: str
    note: str
    """Who it is, where its name does not say; may be empty."""
    returns: Estimate | None
    """Over the seeds that did not fail; None where all did."""
    overall: Estimate | None
    """Over all seeds; None where one has no number."""
    share: float | None
    """Of the gain, over the same seeds as `returns`."""
    overall_share: float | None
    """The same over all seeds."""
    verdict: Verdict | None
    """On the subject, compared with this one; None where there is none to be said, and of the subject itself."""

    @property
    def earned(self) -> str:
        """Its return in words: mean and standard deviation, or one exact number."""
        if self.returns is None:
            return DASH
        return str(self.returns)

    @property
    def over_all_seeds(self) -> str:
        """The mean over all seeds, where some failed; else empty."""
        if self.returns is not None and self.returns.with_failed is None:
            return ""
        return "all seeds: no number" if self.overall is None else f"all {self.overall.count} seeds: {self.overall}"

    @property
    def share_text(self) -> str:
        """The share in per cent."""
        return DASH if self.share is None else format_share(self.share)

    @property
    def share_over_all_seeds(self) -> str:
        """The share over all seeds, where some failed; else empty."""
        if self.overall is None or self.overall_share is None or not self.over_all_seeds:
            return ""
        return f"all {self.overall.count} seeds: {format_share(self.overall_share)}"

    @property
    def difference(self) -> str:
        """The subject's return less this one's, with its interval."""
        if self.verdict is None or self.verdict.difference is None:
            return DASH
        return format_difference(self.verdict.difference, self.verdict.interval)

    def json(self) -> dict[str, Any]:
        """The entry in `table.json`."""
        content: dict[str, Any] = {"label": self.label, "algorithm": self.algorithm}
        if self.returns is not None:
            content["return"] = self.returns.json()
        if self.share is not None:
            content["share"] = self.share
        if self.share_over_all_seeds:
            content["share_all_seeds"] = self.overall_share
        return content | ({} if self.verdict is None else {"subject_less_this": self.verdict.json()})


@dataclass(frozen=True)
class Rivals:
    """The learner of a game (the subject) and everything it is compared with."""

    subject: Rival
    rows: list[Rival]
    """In the report's order."""
    gain: Gain | None
    """None where it is not known."""

    def of(self, algorithm: str) -> Rival | None:
        """The first row of an algorithm."""
        return next((row for row in self.rows if row.algorithm == algorithm), None)

    def json(self) -> dict[str, Any]:
        """The entry in `table.json`."""
        return {"subject": self.subject.json(), "rivals": [row.json() for row in self.rows]}


def rivals_of(group: GameGroup) -> Rivals | None:
    """The subject of a game and its rivals; None where there is no learner, or its return is not known."""
    label = group.subject
    if label is None or DEPLOYED not in group.runs[label].ends:
        return None
    run = group.runs[label]
    ours, gain = run.seed_values(DEPLOYED), _gain(group, run)
    assert ours is not None

    def row(rival: _Entrant, judged: bool = True) -> Rival:
        share, overall = (
            None if each is None or gain is None else gain.share(each.mean) for each in (rival.returns, rival.overall)
        )
        verdict = judge_difference(ours, rival.values) if judged and rival.values is not None else None
        return Rival(rival.label, rival.algorithm, rival.note, rival.returns, rival.overall, share, overall, verdict)

    subject = row(_of_run(label, run, NOTES.get(run.algorithm, "")), judged=False)
    return Rivals(subject, [row(each) for each in _entrants(group, label)], gain)


@dataclass(frozen=True)
class _Entrant:
    """A rival before it is compared."""

    label: str
    algorithm: str
    note: str
    returns: Estimate | None
    overall: Estimate | None
    values: SeedValues | None
    """None where nothing can be compared with it."""


def _of_run(label: str, run: ReportedRun, note: str = "", exact: bool = False) -> _Entrant:
    returns, overall = run.estimate(DEPLOYED), run.over_all_seeds(DEPLOYED)
    if not run.completed:
        note = f"{note}{'; ' if note else ''}interrupted: as far as iteration {run.iterations}"
    if exact and returns is not None:
        one = Estimate.over(np.array([returns.mean]))
        return _Entrant(label, run.algorithm, note, one, one, SeedValues.exactly(one.mean))
    return _Entrant(label, run.algorithm, note, returns, overall, run.seed_values(DEPLOYED))


def _entrants(group: GameGroup, subject: str) -> Iterator[_Entrant]:
    run = group.runs[subject]
    learner, expert = group.sides
    firm = (
        f"given both rewards; its {learner} {learner.verb('plays', 'play')} thirty times more firmly than the {expert}"
    )
    yield from _exactly(run, "sharp", "sharp MARL", firm)
    others = [(label, each) for label, each in group.runs.items() if label != subject and DEPLOYED in each.ends]
    if not any(each.algorithm == "marl" for _, each in others):
        yield from _marl_without_a_run(group, run)
    for label, each in sorted(others, key=lambda other: _rank(other[1].algorithm)):
        note = "given both rewards" if each.given_the_rewards else NOTES.get(each.algorithm, "")
        # MARL of a finite game is an equilibrium, the same with every seed.
        yield _of_run(label, each, note, exact=each.algorithm == "marl" and not group.words.trained)
    at_random = f"{learner.verb('a ', '')}{learner} that {learner.verb(*group.words.reference)}"
    yield from _exactly(run, "random", "random play", at_random)


def _rank(algorithm: str) -> int:
    return ORDER.index(algorithm) if algorithm in ORDER else len(ORDER)


def _exactly(run: ReportedRun, name: str, label: str, note: str) -> Iterator[_Entrant]:
    """A reference that is the same number for every seed, where the run holds it."""
    found = run.over_all_seeds(f"{name}_return_learner")
    if found is not None:
        one = Estimate.over(run.ends[f"{name}_return_learner"][:1])
        yield _Entrant(label, name, note, one, one, SeedValues.exactly(one.mean))


def _marl_without_a_run(group: GameGroup, run: ReportedRun) -> Iterator[_Entrant]:
    for entrant in _exactly(run, "truth", algorithm_style("marl").name, "given both rewards"):
        if not group.words.trained:
            yield _Entrant(entrant.label, "marl", entrant.note, entrant.returns, entrant.overall, entrant.values)
        else:
            # One pair that was trained together: its learner was never deployed.
            note = "given both rewards; one pair as it was trained, not deployed: no verdict"
            yield _Entrant(entrant.label, "marl", note, entrant.returns, entrant.overall, None)


def _gain(group: GameGroup, run: ReportedRun) -> Gain | None:
    """From random play to the best commitment; in a game whose policies are trained, to MARL deployed."""
    random, ceiling = (run.over_all_seeds(f"{name}_return_learner") for name in ("random", "ceiling"))
    marl = group.of("marl")
    deployed = None if marl is None or not group.words.trained else marl.estimate(DEPLOYED)
    best = ceiling or deployed
    return None if random is None or best is None else Gain(random.mean, best.mean, ceiling is not None)
