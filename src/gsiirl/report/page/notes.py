"""Sentences beside the takeaways: warnings, and what a game of its kind has to tell besides returns."""

from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.read.verdict import judge_difference
from gsiirl.report.tables.quality import METRICS
from gsiirl.report.words.algorithms import algorithm_style
from gsiirl.report.words.numbers import format_number, format_share
from gsiirl.report.words.sentences import enumeration

RATES = {
    "collision_rate": "the two collide",
    "goal_rate_robot": "the robot reaches its goal",
    "goal_rate_human": "the human reaches its own",
}
FAILING = (
    "a seed has failed when a number of it is not finite or its learner, deployed, ends below random play: that is "
    "decided by the true return, which no learner sees"
)


def notes(group: GameGroup) -> list[str]:
    """What there is to tell of the learner that is compared with all others."""
    label = group.subject
    if label is None or not group.runs[label].kept_seeds:
        return []
    run = group.runs[label]
    return [*_crossing_notes(group, label, run), *_deception_note(label, run), *_misfit(label, run)]


def warnings(group: GameGroup) -> list[str]:
    """Failed seeds, values that are not finite, and interrupted runs."""
    return [sentence for label, run in group.runs.items() for sentence in _warnings(label, run)]


def _crossing_notes(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    """Collisions and arrivals beside those of MARL, deployed too, and the error of the human's goal."""
    sentences: list[str] = []
    rates = [_rate(group, run, metric, words) for metric, words in RATES.items() if metric in run.final]
    if rates:
        marl = group.of("marl")
        beside = "" if marl is None or not set(RATES) & set(marl.final) else " (in brackets MARL's, deployed too)"
        included = ", failed seeds included" if run.failed_seeds else ""
        sentences.append(f"In the encounters of {label}'s robot{included}{beside}, {enumeration(rates)}.")
    error = _over_all(run, "human_goal_error")
    if error is not None:
        radius = group.game.get("goal_radius")
        told = "" if not isinstance(radius, int | float) else f"; the goal has radius {format_number(radius)}"
        sentences.append(f"{label} places the human's goal {error} from where it is{told}{_included(run)}.")
    return sentences


def _rate(group: GameGroup, run: ReportedRun, metric: str, words: str) -> str:
    rate, ours, marl = _over_all(run, metric), run.seed_values(metric), group.of("marl")
    assert rate is not None, "asked of a metric that the run has"
    assert ours is not None
    text = f"{words} in {format_share(rate.mean)}"
    theirs, mean = (None, None) if marl is None else (marl.seed_values(metric), _over_all(marl, metric))
    if theirs is None or mean is None:
        return text
    verdict = judge_difference(ours, theirs).words("more often", "less often")
    return f"{text} ({format_share(mean.mean)}: {verdict})"


def _over_all(run: ReportedRun, metric: str) -> Estimate | None:
    """Over all seeds, as verdicts are; over those that did not fail where a failed one has no number."""
    return run.over_all_seeds(metric) or run.estimate(metric)


def _included(run: ReportedRun) -> str:
    return "; failed seeds included" if run.failed_seeds else ""


def _deception_note(label: str, run: ReportedRun) -> list[str]:
    """In how many seeds the adversary's two landmarks were told apart."""
    preference = run.ends.get("target_preference")
    if preference is None:
        return []
    return [
        f"That the adversary wants to be near its target rather than near the other landmark, {label} found out in "
        f"{int((preference > 0).sum())} of {len(preference)} seeds."
    ]


def _misfit(label: str, run: ReportedRun) -> list[str]:
    """The feature gap, and the part of it that sampling alone explains."""
    found = _estimates(run, "feature_gap", "feature_gap_noise")
    if found is None:
        return []
    gap, noise = found
    return [
        f"What the learned reward of {label} makes the expert do differs from what the expert did by "
        f"{format_number(gap.mean, 3)} in its features; sampling alone would make {format_number(noise.mean, 3)}"
        f"{_included(run)}."
    ]


def _estimates(run: ReportedRun, *metrics: str) -> list[Estimate] | None:
    """The estimates of all the metrics, or None where the run lacks one."""
    found = [each for each in (_over_all(run, metric) for metric in metrics) if each is not None]
    return found if len(found) == len(metrics) else None


def _warnings(label: str, run: ReportedRun) -> list[str]:
    sentences: list[str] = []
    if run.failed_seeds:
        several, count = len(run.failed_seeds) > 1, len(run.seeds)
        sentences.append(
            f"{len(run.failed_seeds)} of {count} seeds of {label} failed "
            f"(seed{'s' * several} {', '.join(map(str, run.failed_seeds))}); {FAILING}. Figures and means leave "
            f"{'them' if several else 'it'} out: {len(run.kept_seeds)} of {count} remain. Means over all {count} seeds "
            "stand beside them, and verdicts count all seeds."
        )
    shown = [metric for metric in run.metrics.columns if metric in METRICS or "_return_" in metric]
    broken = {metric: run.not_finite(metric) for metric in shown}
    told = [f"{metric} (seed {', '.join(map(str, seeds))})" for metric, seeds in broken.items() if seeds]
    if told:
        sentences.append(
            f"Along the iterations of {label} not every value is finite: {'; '.join(told)}. Such a seed is left out of "
            "the curves of that metric."
        )
    if not run.completed:
        sentences.append(
            f"The run of {algorithm_style(run.algorithm).name} in {run.path.name} was interrupted: shown as far as "
            f"iteration {run.iterations}; gsiirl resume goes on with it."
        )
    return sentences
