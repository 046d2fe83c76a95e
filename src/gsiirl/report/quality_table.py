"""How good each run is beyond its returns."""

from dataclasses import dataclass
from typing import Any

from gsiirl.report.estimate import Estimate, format_number, format_share
from gsiirl.report.group import GameGroup
from gsiirl.report.run import ReportedRun


@dataclass(frozen=True)
class Metric:
    """How a metric is named, explained and printed."""

    heading: str
    meaning: str
    form: str = "number"
    """`number`, `share` (printed in per cent) or `count`."""


METRICS = {
    "regret": Metric(
        "regret",
        "what the deployed learner misses, as a share of what lies between the worst and the best commitment that a "
        "search with the true reward finds (discounted)",
        "share",
    ),
    "ceiling_return_learner": Metric(
        "best commitment", "the learner's return at the best one found; no learner knows it"
    ),
    "sharp_return_learner": Metric(
        "sharp MARL",
        "the learner's return at an equilibrium of both true rewards, it being thirty times sharper than the expert",
    ),
    "expert_reward_pearson": Metric(
        "Pearson, expert's reward", "correlation with the truth over reachable pairs; 1 is perfect"
    ),
    "expert_reward_pearson_played": Metric(
        "Pearson where they go", "the same, over the steps of the episodes that are deployed at the end"
    ),
    "dependent_reward_pearson": Metric(
        "Pearson, dependent reward", "as of the expert's, for the learner's expert-dependent reward"
    ),
    "expert_reward_epic": Metric("EPIC distance", "0: the same reward up to scale and shaping; 1: the opposite"),
    "target_preference": Metric(
        "target preference",
        "learned weight of the adversary's distance to its target, less that of the other landmark, in the sense of "
        "wanting to be near; above 0: ranked right",
    ),
    "human_goal_error": Metric(
        "error of the human's goal", "distance of the place that the learned reward likes best to the true goal"
    ),
    "collision_rate": Metric("collisions", "share of encounters in which robot and human collide", "share"),
    "goal_rate_robot": Metric("robot arrives", "share of encounters in which the robot reaches its goal", "share"),
    "goal_rate_human": Metric("human arrives", "share of encounters in which the human reaches its goal", "share"),
    "nash_gap": Metric("NashConv", "what both sides together could gain by changing alone; 0 is an equilibrium"),
    "exploitability_learner": Metric(
        "exploitability, learner",
        "what a best response trained in the learner's place gains over it, of the return's size",
        "share",
    ),
    "exploitability_expert": Metric("exploitability, expert", "the same in the expert's place", "share"),
    "feature_gap": Metric("feature gap", "distance of expected and demonstrated features"),
    "feature_gap_noise": Metric(
        "feature gap of sampling alone", "what the gap would be if the reward were right: the rest of it is misfit"
    ),
    "expert_trajectories": Metric("trajectories asked", "demonstrations asked of the expert, a seed", "count"),
}
"""In the table's order."""


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
        form = METRICS[metric].form
        if form == "count":
            return f"{estimate.mean:.0f}"
        if form == "share":
            return f"{format_number(100 * estimate.mean, 1)} ± {format_share(estimate.std)}"
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
        # What MARL comes to stands in its run under either name.
        kinds = ("", "truth_") if run.given_the_rewards else ("",)
        estimates = {metric: _first(run, [kind + metric for kind in kinds]) for metric in METRICS}
        rows.append(QualityRow(label, run, {name: each for name, each in estimates.items() if each is not None}))
    return rows


def _first(run: ReportedRun, metrics: list[str]) -> Estimate | None:
    return next((each for each in map(run.estimate, metrics) if each is not None), None)


def used_metrics(rows: list[QualityRow]) -> list[str]:
    """Metrics that at least one run has, in the table's order."""
    return [metric for metric in METRICS if any(metric in row.metrics for row in rows)]
