"""The table of all metrics but returns."""

from dataclasses import dataclass
from typing import Any

from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.words.numbers import format_number, format_share


@dataclass(frozen=True)
class MetricWords:
    """Name, meaning and form of a metric in the table."""

    heading: str
    meaning: str
    form: str = "number"
    """`number`, `share` (printed in per cent) or `count`."""


METRICS = {
    "regret": MetricWords(
        "regret",
        "what the deployed learner misses, as a share of what lies between the worst and the best commitment that a "
        "search with the true reward finds (discounted)",
        "share",
    ),
    "ceiling_return_learner": MetricWords(
        "best commitment", "the learner's return at the best one found; no learner knows it"
    ),
    "sharp_return_learner": MetricWords(
        "sharp MARL",
        "the learner's return at an equilibrium of both true rewards, it being thirty times sharper than the expert",
    ),
    "expert_reward_pearson": MetricWords(
        "Pearson, expert's reward", "correlation with the truth over reachable pairs; 1 is perfect"
    ),
    "expert_reward_pearson_played": MetricWords(
        "Pearson where they go", "the same, over the steps of the episodes that are deployed at the end"
    ),
    "dependent_reward_pearson": MetricWords(
        "Pearson, dependent reward", "as of the expert's, for the learner's expert-dependent reward"
    ),
    "expert_reward_spearman": MetricWords(
        "Spearman, expert's reward", "correlation of ranks: is the order of the rewards right? 1 is perfect"
    ),
    "expert_reward_epic": MetricWords(
        "EPIC distance", "0: the same reward up to scale and a constant; 0.71: unrelated; 1: the opposite"
    ),
    "expert_reward_epic_played": MetricWords("EPIC where they go", "the same, over the steps of the deployed episodes"),
    "expert_reward_starc": MetricWords(
        "STARC distance", "likewise, up to scale and shaping by a potential, with the game's own transitions"
    ),
    "expert_reward_pearson_identified": MetricWords(
        "Pearson, identified part", "as above, apart from what no answer of the expert can show"
    ),
    "expert_reward_epic_identified": MetricWords("EPIC, identified part", "likewise"),
    "expert_reward_starc_identified": MetricWords("STARC, identified part", "likewise"),
    "target_preference": MetricWords(
        "target preference",
        "learned weight of the adversary's distance to its target, less that of the other landmark, in the sense of "
        "wanting to be near; above 0: ranked right",
    ),
    "human_goal_error": MetricWords(
        "error of the human's goal", "distance of the place that the learned reward likes best to the true goal"
    ),
    "collision_rate": MetricWords("collisions", "share of encounters in which robot and human collide", "share"),
    "goal_rate_robot": MetricWords("robot arrives", "share of encounters in which the robot reaches its goal", "share"),
    "goal_rate_human": MetricWords("human arrives", "share of encounters in which the human reaches its goal", "share"),
    "nash_gap": MetricWords(
        "NashConv",
        "what both sides together could gain if each changed alone; 0 at an equilibrium, which a commitment is not and "
        "need not be",
    ),
    "exploitability_learner": MetricWords(
        "exploitability, learner",
        "what a best response trained in the learner's place gains over it, of the return's size",
        "share",
    ),
    "exploitability_expert": MetricWords("exploitability, expert", "the same in the expert's place", "share"),
    "feature_gap": MetricWords("feature gap", "distance of expected and demonstrated features"),
    "log_likelihood_lost": MetricWords(
        "log-likelihood lost",
        "how much less likely a held-out episode of the expert is under the learned reward than under the true one, "
        "in nats; 0 is perfect",
    ),
    "feature_gap_noise": MetricWords(
        "feature gap of sampling alone", "what the gap would be if the reward were right: the rest of it is misfit"
    ),
    "expert_trajectories": MetricWords("trajectories asked", "demonstrations asked of the expert, a seed", "count"),
}
"""Metrics in the table's order."""


DASH = "\N{EN DASH}"


@dataclass(frozen=True)
class QualityRow:
    """The metrics of one run."""

    label: str
    run: ReportedRun
    metrics: dict[str, Estimate]

    @property
    def seeds(self) -> str:
        """Number of kept seeds, and which failed."""
        failed = ", ".join(map(str, self.run.failed_seeds))
        return f"{len(self.run.kept_seeds)} of {len(self.run.seeds)}" + (f" (failed: {failed})" if failed else "")

    @property
    def wall_time(self) -> str:
        """Wall time in seconds or minutes, or a dash where it is not known."""
        seconds = self.run.wall_seconds
        if seconds is None:
            return DASH
        return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"

    def cell(self, metric: str) -> str:
        """A metric as text, or a dash where the run does not have it or it is not defined."""
        estimate = self.metrics.get(metric)
        return DASH if estimate is None else _in_words(estimate, METRICS[metric].form)

    def over_all_seeds(self, metric: str) -> str:
        """A metric over all seeds as text; empty where no seed failed."""
        estimate = self.metrics.get(metric)
        if estimate is None or not self.run.failed_seeds:
            return ""
        everyone = estimate.with_failed
        return "all seeds: no number" if everyone is None else f"all: {_in_words(everyone, METRICS[metric].form)}"

    def json(self) -> dict[str, Any]:
        """The entry in `table.json`; metrics that the run does not have are absent."""
        content: dict[str, Any] = {
            "label": self.label,
            "algorithm": self.run.algorithm,
            "seeds": self.run.seeds,
            "failed_seeds": self.run.failed_seeds,
            "iterations": self.run.iterations,
            "completed": self.run.completed,
        }
        wall = {} if self.run.wall_seconds is None else {"wall_seconds": self.run.wall_seconds}
        return content | {name: each.json() for name, each in self.metrics.items()} | wall


def _in_words(estimate: Estimate, form: str) -> str:
    if form == "count":
        return format_number(estimate.mean, 0)
    if form == "share":
        mean = format_number(100 * estimate.mean, 1)
        return f"{mean} %" if estimate.count == 1 else f"{mean} ± {format_share(estimate.std)}"
    return estimate.text(3)


def judge(group: GameGroup) -> list[QualityRow]:
    """A row for each run."""
    return [QualityRow(label, run, _metrics(run)) for label, run in group.runs.items()]


def _metrics(run: ReportedRun) -> dict[str, Estimate]:
    """The metrics of a run; a run of MARL may hold them as `truth_` ones."""
    estimates = {name: run.estimate(name) for name in METRICS}
    if run.given_the_rewards:
        estimates = {name: each or run.estimate(f"truth_{name}") for name, each in estimates.items()}
    return {name: each for name, each in estimates.items() if each is not None}


def used_metrics(rows: list[QualityRow]) -> list[str]:
    """Names of the metrics that at least one run has, defined or not, in the table's order."""
    return [metric for metric in METRICS if any(metric in row.metrics or metric in row.run.undefined for row in rows)]
