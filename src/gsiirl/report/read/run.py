"""A run as the report reads it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.program.command import command
from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.made import Made
from gsiirl.report.read.undefined import undefined_correlations
from gsiirl.report.read.verdict import SeedValues
from gsiirl.runs import GIVEN_THE_REWARDS, LearnedParameters, RunFolder, Summary, summarise
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.files.numbers import LARGEST
from gsiirl.runs.policies import DRAWS
from gsiirl.runs.summary import last_iterations


@dataclass(frozen=True)
class MetricCurve:
    """A metric over iterations: mean and standard deviation over seeds, each of shape [iterations]."""

    iteration: np.ndarray
    mean: np.ndarray
    std: np.ndarray


@dataclass(frozen=True)
class ReportedRun:
    """The results of a run: of the seeds that did not fail (the kept seeds), where nothing else is said."""

    path: Path
    experiment: str
    algorithm: str
    game: dict[str, Any]
    seeds: list[int]
    failed_seeds: list[int]
    iterations: int
    completed: bool
    final: dict[str, np.ndarray]
    """Per metric the values of the last iteration, of shape [kept seeds]; without those of `undefined`."""
    ends: dict[str, np.ndarray]
    """The same of all seeds, failed ones included, in the order of `seeds`; NaN where there is no number."""
    undefined: frozenset[str]
    """Correlations that there are not: with a reward that is the same whatever happens."""
    metrics: polars.DataFrame
    learned: LearnedParameters | None
    expert_draws: np.ndarray | None
    """Draws from the posterior of the weights of r_e in reward units, [kept seeds, draws, features]; None for none."""
    paths: polars.DataFrame | None
    reward_map: polars.DataFrame | None
    wall_seconds: float | None
    made: Made

    @classmethod
    def read(cls, path: Path) -> "ReportedRun":
        """The run in a folder; of an interrupted one the iterations that were finished.

        Raises:
            InputError: the folder holds no run, a damaged one, or one without any finished iteration.
        """
        folder = RunFolder.open(path)
        metrics = folder.metrics()
        if metrics.is_empty():
            raise InputError(str(path), "has no finished iteration yet", f"use {command('resume', path)} first")
        summary = folder.summary() or summarise(folder.config, metrics, completed=False)
        environment = folder.environment()
        final = {name: np.array(each.per_seed) for name, each in summary.final.items()}
        undefined, learned = undefined_correlations(final), folder.load_learned(summary)
        return cls(
            path=path,
            experiment=summary.experiment,
            algorithm=_algorithm(folder.config),
            game=folder.game,
            seeds=summary.seeds,
            failed_seeds=summary.failed_seeds,
            iterations=summary.iterations,
            completed=summary.completed,
            final={name: values for name, values in final.items() if name not in undefined},
            ends=ends_of(metrics),
            undefined=undefined,
            metrics=metrics.filter(~polars.col("seed").is_in(summary.failed_seeds)).drop(*undefined),
            learned=learned,
            expert_draws=_expert_draws(folder, learned, summary),
            paths=folder.paths(summary),
            reward_map=folder.reward_map(summary),
            wall_seconds=None if environment is None else environment.wall_seconds,
            made=Made.of(folder, environment, summary.seeds),
        )

    @property
    def kept_seeds(self) -> list[int]:
        """Seeds that did not fail."""
        return [seed for seed in self.seeds if seed not in self.failed_seeds]

    def trajectories(self, columns: Sequence[str]) -> list[polars.DataFrame]:
        """The recorded trajectories, sorted by seed and number, each by step; [] where none is recorded.

        Raises:
            InputError: the table of the paths lacks one of `columns`.
        """
        if self.paths is None:
            return []
        path, keys = self.path / "paths.parquet", ("seed", "trajectory", "step")
        missing = [name for name in columns if name not in self.paths.columns]
        if missing:
            raise InputError(str(path), f"is damaged: it has no column {missing[0]}", START_AGAIN)
        kept = self.paths.filter(polars.col("seed").is_in(self.kept_seeds)).sort(keys)
        if (kept["step"] != kept.select(polars.int_range(polars.len()).over("seed", "trajectory")).to_series()).any():
            raise InputError(str(path), "is damaged: it lacks a step, or has one twice", START_AGAIN)
        return kept.partition_by("seed", "trajectory", maintain_order=True)

    @property
    def prior_deviation(self) -> np.ndarray | None:
        """Standard deviation of the prior of the weights of r_e in reward units, [kept seeds]; None for none."""
        prior = self.final.get("prior_deviation")
        return None if prior is None or self.learned is None else self.learned.scales["expert_reward"] * prior

    @property
    def given_the_rewards(self) -> bool:
        """Whether the algorithm is given both rewards and learns none (MARL)."""
        return self.algorithm in GIVEN_THE_REWARDS

    def estimate(self, metric: str) -> Estimate | None:
        """The estimate of a final metric, that over all seeds beside it; None where the run does not have it."""
        values = self.final.get(metric)
        if values is None or not len(values):
            return None
        return replace(Estimate.over(values), with_failed=self.over_all_seeds(metric) if self.failed_seeds else None)

    def over_all_seeds(self, metric: str) -> Estimate | None:
        """The estimate over all seeds, failed ones included; None where one of them has no finite number."""
        values = self.ends.get(metric)
        return Estimate.over(values) if values is not None and np.isfinite(values).all() else None

    def seed_values(self, metric: str) -> SeedValues | None:
        """A final metric of all seeds, failed ones included, to be compared with another run's."""
        values = self.ends.get(metric)
        return None if values is None else SeedValues(values, self.seeds)

    @property
    def explores(self) -> bool:
        """Whether some interactions were played to explore: to learn about the expert, not to earn."""
        return "exploring" in self.metrics.columns and bool((self.metrics["exploring"] > 0).any())

    def curve(self, metric: str) -> MetricCurve | None:
        """A metric over iterations, or None where the run does not have it; of what `seed_curves` holds."""
        table = self.seed_curves(metric)
        if table.is_empty():
            return None
        table = (
            table.group_by("iteration")
            .agg(mean=polars.col("value").mean(), std=polars.col("value").std(ddof=1).fill_null(0.0))
            .sort("iteration")
        )
        return MetricCurve(*(table[name].to_numpy() for name in ("iteration", "mean", "std")))

    def seed_curves(self, metric: str) -> polars.DataFrame:
        """A table of `seed`, `iteration` and the `value` of a metric, empty where the run does not have it.

        Left out are the seeds that `not_finite` names, and interactions that were played to explore.
        """
        table = self._along(metric).filter(~polars.col("seed").is_in(self.not_finite(metric))).drop("finite")
        if self.explores:
            played_to_earn = self.metrics.filter(polars.col("exploring") == 0).select("seed", "iteration")
            table = table.join(played_to_earn, on=["seed", "iteration"], how="semi")
        return table

    def not_finite(self, metric: str) -> list[int]:
        """Kept seeds with a value of the metric that is not finite."""
        return self._along(metric).filter(~polars.col("finite"))["seed"].unique().sort().to_list()

    def _along(self, metric: str) -> polars.DataFrame:
        """A table of `seed`, `iteration`, `value` and `finite`, from the first iteration with a measured value."""
        if metric not in self.metrics.columns:
            return polars.DataFrame(schema={"seed": int, "iteration": int, "value": float, "finite": bool})
        value = polars.col(metric)
        table = self.metrics.select(
            "seed", "iteration", value=value, finite=(value.cast(float).abs() <= LARGEST).fill_null(False)
        )
        begin = table.filter("finite")["iteration"].min()
        return table.clear() if begin is None else table.filter(polars.col("iteration") >= begin)

    def weights(self, parameter: str) -> np.ndarray | None:
        """Learned weights in reward units, of shape [kept seeds, features], or None where there are none."""
        if self.learned is None or parameter not in self.learned.arrays:
            return None
        kept = [index for index, seed in enumerate(self.learned.seeds) if seed not in self.failed_seeds]
        return self.learned.weights(parameter)[kept] if kept else None


def _expert_draws(folder: RunFolder, learned: LearnedParameters | None, summary: Summary) -> np.ndarray | None:
    # Only what has a posterior has a prior; the networks of other runs need not be read.
    policies = folder.load_policies() if "prior_deviation" in summary.final else None
    if learned is None or policies is None or DRAWS not in policies:
        return None
    kept = [place for place, seed in enumerate(summary.seeds) if seed not in summary.failed_seeds]
    draws, weights = policies[DRAWS], learned.arrays["expert_reward"]
    if draws.ndim != 3 or draws.shape[2] != weights.shape[1]:
        raise InputError(str(folder.path / "policies.safetensors"), f"{DRAWS} does not fit the weights", START_AGAIN)
    return learned.scales["expert_reward"] * draws[kept] if kept else None


def ends_of(metrics: polars.DataFrame) -> dict[str, np.ndarray]:
    """Per metric the last value of every seed, in the order of the seeds; NaN where there is no number."""
    last = last_iterations(metrics).drop("seed", "iteration")
    return {name: last[name].cast(float).fill_null(np.nan).to_numpy() for name in last.columns}


def _algorithm(config: dict[str, Any]) -> str:
    """The name of the algorithm; MARL solved by MADDPG has its own, however the configuration says so."""
    by_maddpg = config["algorithm"] == "marl" and config.get("solver") == "maddpg"
    return "marl-maddpg" if by_maddpg else config["algorithm"]
