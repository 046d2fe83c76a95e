"""What each change of an ablation brought, seed by seed."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.report.estimate import Estimate
from gsiirl.runs import Ablation, RunFolder, Variant


@dataclass(frozen=True)
class VariantResult:
    """One variant on one graph, over all its seeds: none is left out for ending badly.

    `deployed` (seeds,) is the learner's deployed return, `marl` that of MARL, `random` of a learner that acts at
    random; `pearson` (seeds,) the correlation of the expert's reward; `solves` and `trajectories` what a seed used.
    """

    deployed: np.ndarray
    pearson: np.ndarray
    marl: float
    random: float
    solves: float
    trajectories: float

    @property
    def below_random(self) -> int:
        """Seeds that ended below random play: failed, elsewhere."""
        return int(np.sum(self.deployed < self.random))


@dataclass(frozen=True)
class Effect:
    """What a change brought on one graph: paired differences of deployed returns, seed by seed."""

    graph: str
    difference: Estimate

    @property
    def verdict(self) -> str:
        """By the 95 % interval of the mean difference."""
        if self.difference.low > 0.0:
            return "better"
        return "worse" if self.difference.high < 0.0 else "no difference"


@dataclass(frozen=True)
class AblationResults:
    """All results, by (graph, variant's name)."""

    plan: Ablation
    results: dict[tuple[str, str], VariantResult]

    @classmethod
    def read(cls, folder: Path) -> "AblationResults":
        """Read a finished ablation.

        Raises:
            InputError: a run is missing, interrupted or damaged.
        """
        plan = Ablation.read(folder)
        results = {
            (graph, variant.name): _result(folder / graph / variant.name)
            for graph in plan.graphs
            for variant in plan.variants
        }
        return cls(plan, results)

    def effects(self, variant: Variant) -> list[Effect]:
        """What a change brought over the variant before it; none for the first."""
        place = self.plan.variants.index(variant)
        if place == 0:
            return []
        before, after = self.plan.variants[place - 1].name, variant.name
        return [
            Effect(graph, Estimate.over(self.results[graph, after].deployed - self.results[graph, before].deployed))
            for graph in self.plan.graphs
        ]


def _result(path: Path) -> VariantResult:
    folder = RunFolder.open(path)
    summary = folder.summary()
    if summary is None or not summary["completed"]:
        raise InputError(str(path), "is not finished", "run gsiirl ablation again: it goes on")
    last = folder.metrics().filter(polars.col("iteration") == summary["iterations"]).sort("seed")
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
