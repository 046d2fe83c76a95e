"""The results of an ablation, and the effect of each of its changes."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.report.read.made import Made, MadeGroup
from gsiirl.report.read.undefined import undefined_correlations
from gsiirl.report.read.verdict import SeedValues, judge_difference
from gsiirl.report.words.numbers import format_number
from gsiirl.runs import Ablation, AblationVariant, RunFolder


@dataclass(frozen=True)
class VariantResult:
    """One variant on one graph; no seed is left out for ending badly."""

    deployed: np.ndarray
    """The learner's deployed return, [seeds]."""
    pearson: np.ndarray
    """Correlation of the expert's learned reward with the true one, [seeds]."""
    marl: float
    """The learner's return under MARL."""
    random: float
    """The learner's return when it plays at random."""
    solves: float
    """Games solved by one seed."""
    trajectories: float
    """Trajectories asked for by one seed."""
    seeds: list[int]
    made: Made

    @property
    def returns(self) -> SeedValues:
        """The deployed returns, to be compared."""
        return SeedValues(self.deployed, self.seeds)

    @property
    def correlation(self) -> str:
        """Mean correlation of the learned reward, or a dash where there is none."""
        undefined = undefined_correlations({"expert_reward_pearson": self.pearson})
        return "\N{EN DASH}" if undefined else format_number(float(self.pearson.mean()), 2)

    @property
    def below_random(self) -> int:
        """Number of seeds that ended below random play."""
        return int(np.sum(self.deployed < self.random))


@dataclass(frozen=True)
class AblationResults:
    """The results of all variants on all graphs."""

    plan: Ablation
    results: dict[tuple[str, str], VariantResult]
    """By graph and name of the variant."""

    @classmethod
    def read(cls, folder: Path) -> "AblationResults":
        """Read a finished ablation.

        Raises:
            InputError: a run is missing, interrupted or damaged.
        """
        plan = Ablation.read(folder)
        cells = [(graph, variant.name) for graph in plan.graphs for variant in plan.variants]
        results = {(graph, name): _result(folder / graph / name) for graph, name in cells}
        if len({each.deployed.shape for each in results.values()}) > 1:
            raise InputError(
                str(folder), "holds runs of other numbers of seeds", "start the ablation in another folder"
            )
        return cls(plan, results)

    def of_variant(self, variant: AblationVariant) -> list[VariantResult]:
        """The results of one variant, in the order of the graphs."""
        return [self.results[graph, variant.name] for graph in self.plan.graphs]

    def verdicts(self, variant: AblationVariant) -> list[str]:
        """What each graph says of a variant beside the one before it; [] for the first variant."""
        place = self.plan.variants.index(variant)
        if place == 0:
            return []
        before, after = self.of_variant(self.plan.variants[place - 1]), self.of_variant(variant)
        pairs = zip(before, after, strict=True)
        return [judge_difference(changed.returns, unchanged.returns).words() for unchanged, changed in pairs]

    def verdict(self, variant: AblationVariant) -> str:
        """On how many graphs a variant is better than the one before it, the same, worse, or nothing can be told."""
        counts = Counter(self.verdicts(variant))
        order = sorted(counts, key=lambda words: ("better", "the same", "worse", words).index(words))
        return ", ".join(f"{words} on {counts[words]}" for words in order)

    @property
    def made(self) -> MadeGroup:
        """How the runs on the first graph were made."""
        first = self.plan.graphs[0]
        return MadeGroup(
            f"The runs on {first.replace('-', ' ')}; on the others they differ in the graph's seed alone",
            {variant.name: self.results[first, variant.name].made for variant in self.plan.variants},
        )

    @property
    def command(self) -> str:
        """The command that makes all of it again."""
        first = self.of_variant(self.plan.variants[0])
        settings = first[0].made.settings
        seeds = ",".join(each.made.settings.get("graph_seed", "?") for each in first)
        words = [f"--{name} {settings[name]}" for name in ("seeds", "iterations", "trajectories") if name in settings]
        return " ".join(["gsiirl ablation --graph-seeds", seeds, *words, "--out ablation"])


def _result(path: Path) -> VariantResult:
    folder = RunFolder.open(path)
    summary = folder.summary()
    if summary is None or not summary.completed:
        raise InputError(str(path), "is not finished", "run gsiirl ablation again: it goes on")
    last = folder.metrics().filter(polars.col("iteration") == summary.iterations).sort("seed")
    try:
        columns = {name: last[name].to_numpy() for name in last.columns}
        return VariantResult(
            deployed=columns["deployed_return_learner"],
            pearson=columns["expert_reward_pearson"],
            marl=float(columns["truth_return_learner"][0]),
            random=float(columns["random_return_learner"][0]),
            solves=float(columns["game_solves"].mean()),
            trajectories=float(columns["expert_trajectories"].mean()),
            seeds=summary.seeds,
            made=Made.of(folder, folder.environment(), summary.seeds),
        )
    except (KeyError, IndexError) as error:
        raise InputError(str(path), f"lacks a metric ({error!r})", "start the ablation in another folder") from error
