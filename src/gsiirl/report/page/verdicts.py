"""Sentences about the results of one game, computed from the numbers that its tables show."""

from gsiirl.report.read.estimate import Estimate
from gsiirl.report.read.gap import VERDICTS, gap_to_deployed_marl, gap_to_marl
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.tables.quality import METRICS
from gsiirl.report.words.algorithms import algorithm_style
from gsiirl.report.words.numbers import format_number, format_share

HOW = {"gsiirl": "learned by interacting ({})", "ma-irl": "learned from fixed demonstrations ({})"}
"""How a learner learned, by algorithm; of any other that it `learned with` it."""
RATES = {
    "collision_rate": "the two collide",
    "goal_rate_robot": "the robot reaches its goal",
    "goal_rate_human": "the human reaches its own",
}


def verdicts(group: GameGroup) -> list[str]:
    """The sentences of one game, most important first."""
    learners = [(label, run) for label, run in group.learners.items() if run.kept_seeds]
    # The project's own algorithm comes first, then those it is compared with.
    learners.sort(key=lambda each: each[1].algorithm != "gsiirl")
    sentences: list[str] = []
    for place, (label, run) in enumerate(learners):
        sentences += _return_verdict(group, label, run, full=place == 0)
        if place == 0:
            sentences += [*_answered_verdict(group, label, run), *_commitment_verdict(group, label, run)]
    for label, run in learners:
        sentences += _reward_verdict(group, label, run)
    for label, run in learners[:1]:
        sentences += [*_crossing_verdict(group, label, run), *_deception_verdict(label, run), *_misfit(label, run)]
    return sentences + [sentence for label, run in group.runs.items() for sentence in _warnings(label, run)]


def _return_verdict(group: GameGroup, label: str, run: ReportedRun, full: bool) -> list[str]:
    """The learner's return; if `full` also MARL's and random play's, and which is better."""
    ends = run.estimate("deployed_return_learner")
    if ends is None:
        return []
    learner, expert = group.sides
    gap, marl = gap_to_marl(group, run), group.reference("truth_return_learner")
    random = group.reference("random_return_learner")
    how = HOW.get(run.algorithm, "learned with {}").format(label)
    text = f"The {learner} that {how} {learner.verb('ends', 'end')} at {ends}"
    if full:
        text += f" against the real {expert}"
        if marl is not None:
            text += f"; MARL, which was given both rewards, at {format_number(marl)}"
        if random is not None:
            does = learner.verb(*group.words.reference)
            text += f"; {learner.verb('a ', '')}{learner} that {does}, at {format_number(random)}"
        text += ". Higher is better" + (f": {learner.verb('it does', 'they do')}" if gap is not None else "")
    elif gap is not None:
        text += ":"
    return [f"{text}." if gap is None else f"{text} {_comparison(gap)}."]


def _answered_verdict(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    """MARL's learner deployed against the real expert, where that differs from its return in training."""
    gap, marl = gap_to_deployed_marl(group, run), group.of("marl")
    pair, met = (None if marl is None else marl.estimate(f"{kind}_return_learner") for kind in ("truth", "deployed"))
    if gap is None or pair is None or met is None or str(pair) == str(met):
        return []
    learner, expert = group.sides
    it = learner.verb("it", "them")
    return [
        f"MARL's figure is what its {learner} {learner.verb('earns', 'earn')} with the {expert} that learned beside "
        f"{it}. Once the real {expert} has answered {it} too, {learner.verb('it ends', 'they end')} at {met}: "
        f"{learner.verb('that', 'those')} of {label} {learner.verb('does', 'do')} {_comparison(gap, 'that')}."
    ]


def _commitment_verdict(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    """The distance to the best commitment, and to the strongest rival that was given both rewards."""
    found = _estimates(run, "regret", "ceiling_return_learner", "sharp_return_learner")
    if found is None:
        return []
    regret, ceiling, sharp = found
    return [
        f"Much of MARL's distance is that its {group.sides[0]} plays softly: one that is thirty times sharper earns "
        f"{format_number(sharp.mean, 3)}. The best commitment that a search with the true reward finds earns "
        f"{format_number(ceiling.mean, 3)}; of what lies between the worst and that, {label} misses "
        f"{format_number(100 * regret.mean, 2)} %."
    ]


def _estimates(run: ReportedRun, *metrics: str) -> list[Estimate] | None:
    """The estimates of all the metrics, or None where the run lacks one."""
    found = [each for each in map(run.estimate, metrics) if each is not None]
    return found if len(found) == len(metrics) else None


def _comparison(gap: Estimate, other: str = "MARL") -> str:
    return f"{VERDICTS[gap.sign]} than {other}" + ("" if gap.sign else " (which lies within the 95 % interval)")


def _reward_verdict(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    """How well the learned reward of the expert agrees with the true one, and what it cost."""
    pearson, asked = run.estimate("expert_reward_pearson"), run.estimate("expert_trajectories")
    if pearson is None:
        return []
    cost = f", after {asked.mean:.0f} observed trajectories a seed" if asked is not None else ""
    return [
        f"The {group.sides[1].possessive} reward as {label} learned it correlates {format_number(pearson.mean, 3)} "
        f"with the true one (1 is perfect){cost}."
    ]


def _crossing_verdict(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    """Collisions, arrivals, and the error of the human's goal."""
    sentences = []
    rates = []
    for metric, words in RATES.items():
        if (rate := run.estimate(metric)) is not None:
            marl = group.reference(f"truth_{metric}")
            beside = "" if marl is None else f" (MARL {format_share(marl)})"
            rates.append(f"{words} in {format_share(rate.mean)}{beside}")
    if rates:
        sentences.append(f"In the encounters of the robot of {label}, {', '.join(rates)}.")
    error = run.estimate("human_goal_error")
    if error is not None:
        radius = group.game.get("goal_radius")
        told = "" if not isinstance(radius, int | float) else f"; the goal has radius {format_number(radius)}"
        sentences.append(f"{label} places the human's goal {error} from where it is{told}.")
    return sentences


def _deception_verdict(label: str, run: ReportedRun) -> list[str]:
    """In how many seeds the adversary's two landmarks were told apart."""
    preference = run.final.get("target_preference")
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
        f"{format_number(gap.mean, 3)} in its features; sampling alone would make {format_number(noise.mean, 3)}."
    ]


def _warnings(label: str, run: ReportedRun) -> list[str]:
    """Failed seeds, values that are not finite, and an interrupted run."""
    sentences = []
    if run.failed_seeds:
        word, verb = ("Seed", "is") if len(run.failed_seeds) == 1 else ("Seeds", "are")
        sentences.append(
            f"{word} {', '.join(map(str, run.failed_seeds))} of {label} failed (not finite, or worse than random play) "
            f"and {verb} left out of every figure and mean; {len(run.kept_seeds)} of {len(run.seeds)} remain."
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
