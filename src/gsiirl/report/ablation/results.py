"""The results of an ablation, and the effect of each of its changes."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.report.read.estimate import Estimate
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

    @property
    def below_random(self) -> int:
        """Number of seeds that ended below random play."""
        return int(np.sum(self.deployed < self.random))


VERDICTS = {1: "better", 0: "no difference", -1: "worse"}
"""By the sign of an effect."""


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

    def effects(self, variant: AblationVariant) -> list[Estimate]:
        """Deployed return less that of the variant before, seed by seed, for each graph; [] for the first variant."""
        place = self.plan.variants.index(variant)
        if place == 0:
            return []
        before, after = self.of_variant(self.plan.variants[place - 1]), self.of_variant(variant)
        pairs = zip(before, after, strict=True)
        return [Estimate.over(changed.deployed - unchanged.deployed) for unchanged, changed in pairs]

    def verdict(self, variant: AblationVariant) -> str:
        """On how many graphs a variant is better than the one before it, no different, and worse."""
        counts = Counter(effect.sign for effect in self.effects(variant))
        return ", ".join(f"{word} on {counts[sign]}" for sign, word in VERDICTS.items() if counts[sign])


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
        )
    except (KeyError, IndexError) as error:
        raise InputError(str(path), f"lacks a metric ({error!r})", "start the ablation in another folder") from error
