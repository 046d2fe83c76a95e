"""How good each run is beyond its returns."""

from dataclasses import dataclass
from typing import Any

from gsiirl.report.estimate import Estimate
from gsiirl.report.group import GameGroup
from gsiirl.report.run import ReportedRun

METRICS = {
    "expert_reward_pearson": (
        "Pearson, expert's reward",
        "correlation with the truth over reachable pairs; 1 is perfect",
    ),
    "dependent_reward_pearson": ("Pearson, dependent reward", "the same for the learner's expert-dependent reward"),
    "expert_reward_epic": ("EPIC distance", "0: the same reward up to scale and shaping; 1: the opposite"),
    "nash_gap": ("NashConv", "what both sides together could gain by changing alone; 0 is an equilibrium"),
    "feature_gap": ("feature gap", "distance of expected and demonstrated features"),
    "expert_trajectories": ("trajectories asked", "demonstrations asked of the expert, a seed"),
}
"""Metric: heading and meaning."""


@dataclass(frozen=True)
class QualityRow:
    """One run."""

    label: str
    run: ReportedRun
    metrics: dict[str, Estimate]

    @property
    def seeds(self) -> str:
        """How many seeds count, in words."""
        failed = self.run.failed_seeds
        text = f"{len(self.run.kept_seeds)} of {len(self.run.seeds)}"
        return text + (f" (failed: {', '.join(map(str, failed))})" if failed else "")

    @property
    def wall_time(self) -> str:
        """Wall time in words, or a dash."""
        seconds = self.run.wall_seconds
        if seconds is None:
            return "\N{EN DASH}"
        return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"

    def cell(self, metric: str) -> str:
        """A metric as text, or a dash where it does not apply."""
        estimate = self.metrics.get(metric)
        if estimate is None:
            return "\N{EN DASH}"
        if metric == "expert_trajectories":
            return f"{estimate.mean:.0f}"
        return f"{estimate.mean:.3f} ± {estimate.std:.3f}".replace("-", "\N{MINUS SIGN}")

    def json(self) -> dict[str, Any]:
        """As it stands in `table.json`; what does not apply is absent."""
        content: dict[str, Any] = {
            "label": self.label,
            "algorithm": self.run.algorithm,
            "seeds": self.run.seeds,
            "failed_seeds": self.run.failed_seeds,
            "iterations": self.run.iterations,
            "completed": self.run.completed,
        }
        content |= {name: each.json() for name, each in self.metrics.items()}
        if self.run.wall_seconds is not None:
            content["wall_seconds"] = self.run.wall_seconds
        return content


def judge(group: GameGroup) -> list[QualityRow]:
    """One row a run."""
    rows = []
    for label, run in group.runs.items():
        estimates = {metric: run.estimate(metric) for metric in METRICS}
        rows.append(QualityRow(label, run, {name: each for name, each in estimates.items() if each is not None}))
    return rows


def used_metrics(rows: list[QualityRow]) -> list[str]:
    """Metrics that at least one run has, in the table's order."""
    return [metric for metric in METRICS if any(metric in row.metrics for row in rows)]
