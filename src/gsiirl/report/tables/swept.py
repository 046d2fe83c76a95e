"""Runs grouped by some of their settings: mean and interval of a metric, and a verdict on every two groups."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.errors import InputError
from gsiirl.report.output.rendering import render
from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.run import ends_of
from gsiirl.report.read.verdict import RULE, SeedValues, Verdict, judge_difference
from gsiirl.report.words.numbers import format_difference, format_number
from gsiirl.runs import RunFolder, Summary

SEEDS = ("seeds", "first_seed")
"""Settings that say which seeds a run has; runs that differ in these alone are pooled."""
EXPERIMENT = "experiment"
DASH = "\N{EN DASH}"


@dataclass(frozen=True)
class SweptRun:
    """A finished run: its settings, and what its seeds end with."""

    settings: dict[str, Any]
    summary: Summary
    ends: dict[str, np.ndarray]
    """Per metric the last value of every seed, failed ones included."""

    @classmethod
    def read(cls, path: Path) -> "SweptRun | None":
        """The run in a folder; None where it has not ended.

        Raises:
            InputError: the folder holds no run, or a damaged one.
        """
        folder = RunFolder.open(path)
        summary = folder.summary()
        if summary is None or not summary.completed:
            return None
        settings = {name: value for name, value in folder.config.items() if name != "format_version"}
        return cls(settings, summary, ends_of(folder.metrics()))


@dataclass(frozen=True)
class Group:
    """The runs that share the settings which the table is by."""

    settings: dict[str, Any]
    runs: list[SweptRun]
    values: SeedValues
    """Of the metric: all seeds of all runs, each with the place of its seed and other settings among all groups'."""

    @property
    def estimate(self) -> Estimate | None:
        """Mean and interval; None where a seed has no finite number."""
        return None if self.values.lacking else Estimate.over(self.values.values)

    @property
    def failed(self) -> int:
        """Seeds that failed; they count."""
        return sum(len(each.summary.failed_seeds) for each in self.runs)

    def cells(self) -> list[str]:
        """Its row of the table: settings, mean, interval, deviation, seeds."""
        told, count = self.estimate, len(self.values.values)
        seeds = f"{count} ({self.failed} failed)" if self.failed else str(count)
        named = [_word(value) for value in self.settings.values()]
        if told is None:
            return [*named, f"{self.values.lacking} without a number", DASH, DASH, seeds]
        digits = _digits(told)
        interval = f"{format_number(told.low, digits)} to {format_number(told.high, digits)}" if count > 1 else DASH
        spread = format_number(told.std, digits) if count > 1 else DASH
        return [*named, format_number(told.mean, digits), interval, spread, seeds]


@dataclass(frozen=True)
class Pair:
    """Two groups that differ in one setting, and what can be said of their difference."""

    first: str
    second: str
    verdict: Verdict

    def cells(self) -> list[str]:
        """Its row of the table."""
        known = self.verdict.difference
        difference = DASH if known is None else format_difference(known, self.verdict.interval)
        return [self.first, self.second, difference, self.verdict.words("higher", "lower")]


def swept_table(paths: Sequence[Path], by: Sequence[str] | None, metric: str) -> tuple[str, list[Path]]:
    """A metric at the end of the runs in `paths` as Markdown, and the runs that have not ended, which it leaves out.

    `by` names the settings that tell the groups apart; without it, all that differ do. Settings that differ within a
    group are averaged over, and two groups are compared seed by seed where the same seeds ran with the same of these.

    Raises:
        InputError: no run has ended, no run has such a setting or metric, or `by` would pool different experiments.
    """
    read = {path: SweptRun.read(path) for path in paths}
    runs = [each for each in read.values() if each is not None]
    if not runs:
        raise InputError("DIR", "holds no finished run", "wait until one has ended")
    differing = _differing(runs)
    fields = differing if by is None else list(by)
    for field in fields:
        if not any(field in run.settings for run in runs):
            raise InputError("--by", f"{field} is no setting of these runs", f"choose from {_names(differing)}")
    if EXPERIMENT in differing and EXPERIMENT not in fields:
        raise InputError("--by", "would pool different experiments", f"add {EXPERIMENT}")
    groups = _groups(runs, fields, [each for each in differing if each not in fields], metric)
    pairs = [_pair(*each) for each in itertools.combinations(groups, 2) if _differ_in_one(*each)]
    table = render(
        "sweep.md",
        metric=metric,
        fields=fields,
        rows=[each.cells() for each in groups],
        pairs=[each.cells() for each in pairs],
        averaged=[each for each in differing if each not in fields],
        rule=RULE.replace("Better or worse", "Higher or lower").replace("the page says", "it is said"),
    )
    return table, [path for path, run in read.items() if run is None]


def _differing(runs: Sequence[SweptRun]) -> list[str]:
    names = dict.fromkeys(name for run in runs for name in run.settings)
    first = runs[0].settings
    absent = object()
    different = [
        name
        for name in names
        if any(run.settings.get(name, absent) != first.get(name, absent) for run in runs) and name not in SEEDS
    ]
    if EXPERIMENT in different:
        # Settings that only some experiments have differ with the experiment.
        different = [name for name in different if all(name in run.settings for run in runs)]
    return different


def _groups(runs: Sequence[SweptRun], fields: list[str], averaged: list[str], metric: str) -> list[Group]:
    known = sorted({name for run in runs for name in run.ends})
    if metric not in known:
        raise InputError("--metric", f"{metric} is no metric of these runs", f"choose from {_names(known)}")
    members: dict[str, list[SweptRun]] = {}
    for run in runs:
        members.setdefault(repr([run.settings.get(field) for field in fields]), []).append(run)
    places: dict[tuple[str, int], int] = {}
    groups = []
    for group in members.values():
        values, seeds = list[float](), list[int]()
        for run in group:
            others = repr([run.settings.get(field) for field in averaged])
            ends = run.ends.get(metric, np.full(len(run.summary.seeds), np.nan))
            for seed, value in zip(run.summary.seeds, ends, strict=True):
                values.append(float(value))
                seeds.append(places.setdefault((others, seed), len(places)))
        if len(set(seeds)) < len(seeds):
            raise InputError("DIR", "holds the same seeds of one setting twice", "give every seed once")
        settings = {field: group[0].settings.get(field) for field in fields}
        groups.append(Group(settings, group, SeedValues(np.array(values), seeds)))
    return groups


def _pair(first: Group, second: Group) -> Pair:
    different = [name for name in first.settings if first.settings[name] != second.settings[name]]
    shared = [f"{name} {_word(value)}" for name, value in first.settings.items() if name not in different]
    (varied,) = different
    one, other = (", ".join([f"{varied} {_word(group.settings[varied])}", *shared]) for group in (first, second))
    return Pair(one, other, judge_difference(first.values, second.values))


def _differ_in_one(first: Group, second: Group) -> bool:
    return sum(first.settings[name] != second.settings[name] for name in first.settings) == 1


def _digits(told: Estimate) -> int:
    """Decimals that show two digits of the interval, or of the mean where there is none: 2 to 6."""
    width = (told.high - told.low) / 2 or abs(told.mean) or 1.0
    return int(np.clip(1 - np.floor(np.log10(width)), 2, 6))


def _word(value: Any) -> str:
    return DASH if value is None else str(value).lower() if isinstance(value, bool) else str(value)


def _names(names: Sequence[str]) -> str:
    return ", ".join(names) or "none: they differ in nothing"
