"""What the figures say, in sentences computed from them."""

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.estimate import format_number, format_share
from gsiirl.report.gap import Gap
from gsiirl.report.group import GameGroup
from gsiirl.report.quality_table import METRICS
from gsiirl.report.run import ReportedRun


def verdicts(group: GameGroup) -> list[str]:
    """The sentences of one game, most important first."""
    learners = [(label, run) for label, run in group.learners.items() if run.kept_seeds]
    # The algorithm of the project comes first, then what it is compared with.
    learners.sort(key=lambda each: each[1].algorithm != "gsiirl")
    sentences = []
    for place, (label, run) in enumerate(learners):
        sentences += _return_verdict(group, label, run, full=place == 0)
        if place == 0:
            sentences += _answered_verdict(group, label, run)
            sentences += _commitment_verdict(group, label, run)
    for label, run in learners:
        sentences += _reward_verdict(group, label, run)
    for label, run in learners[:1]:
        sentences += [*_crossing_verdict(group, label, run), *_deception_verdict(label, run), *_misfit(label, run)]
    for label, run in group.runs.items():
        sentences += _warnings(label, run)
    return sentences


def _return_verdict(group: GameGroup, label: str, run: ReportedRun, full: bool) -> list[str]:
    ends = run.estimate("deployed_return_learner")
    if ends is None:
        return []
    learner, expert = group.sides
    gap, marl = Gap.of(group, run), group.reference("truth_return_learner")
    random = group.reference("random_return_learner")
    text = f"The {learner} that {_how(run.algorithm, label)} {learner.verb('ends', 'end')} at {ends}"
    if full:
        text += f" against the real {expert}"
        if marl is not None:
            text += f"; MARL, which was given both rewards, at {format_number(marl)}"
        if random is not None:
            text += (
                f"; {learner.verb('a ', '')}{learner} that {learner.verb(*group.words.reference)}, at "
                f"{format_number(random)}"
            )
        text += ". Higher is better"
        if gap is not None:
            text += f": {learner.verb('it does', 'they do')}"
    elif gap is not None:
        text += ":"
    return [f"{text}." if gap is None else f"{text} {_comparison(gap)}."]


def _answered_verdict(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    """MARL's pair has only met itself: its learner too earns less once the expert answers what it plays."""
    gap, marl = Gap.to_deployed(group, run), group.of("marl")
    pair, met = (None if marl is None else marl.estimate(f"{kind}_return_learner") for kind in ("truth", "deployed"))
    if gap is None or pair is None or met is None or str(pair) == str(met):
        return []
    learner, expert = group.sides
    return [
        f"MARL's figure is what its {learner} {learner.verb('earns', 'earn')} with the {expert} that learned beside "
        f"{learner.verb('it', 'them')}. Once the real {expert} has answered {learner.verb('it', 'them')} too, "
        f"{learner.verb('it ends', 'they end')} at {met}: {learner.verb('that', 'those')} of {label} "
        f"{learner.verb('does', 'do')} {_comparison(gap, 'that')}."
    ]


def _commitment_verdict(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    """How far from the best commitment, and from the strongest rival that was given both rewards."""
    regret, ceiling, sharp = (
        run.estimate(name) for name in ("regret", "ceiling_return_learner", "sharp_return_learner")
    )
    if regret is None or ceiling is None or sharp is None:
        return []
    learner, _ = group.sides
    return [
        f"Much of MARL's distance is that its {learner} plays softly: one that is thirty times sharper earns "
        f"{format_number(sharp.mean, 3)}. The best commitment that a search with the true reward finds earns "
        f"{format_number(ceiling.mean, 3)}; of what lies between the worst and that, {label} misses "
        f"{format_number(100 * regret.mean, 2)} %."
    ]


def _how(algorithm: str, label: str) -> str:
    if algorithm == "gsiirl":
        return f"learned by interacting ({label})"
    if algorithm == "ma-irl":
        return f"learned from fixed demonstrations ({label})"
    return f"learned with {label}"


def _comparison(gap: Gap, other: str = "MARL") -> str:
    return f"{gap.verdict} than {other}" + (" (which lies within the 95 % interval)" if gap.is_open else "")


def _reward_verdict(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    pearson = run.estimate("expert_reward_pearson")
    if pearson is None:
        return []
    _, expert = group.sides
    asked = run.estimate("expert_trajectories")
    cost = f", after {asked.mean:.0f} observed trajectories a seed" if asked is not None else ""
    return [
        f"The {expert.possessive} reward as {label} learned it correlates {format_number(pearson.mean, 3)} with the "
        f"true one (1 is perfect){cost}."
    ]


def _crossing_verdict(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    sentences = []
    rates = [
        f"{words} in {format_share(rate.mean)}" + ("" if marl is None else f" (MARL {format_share(marl)})")
        for metric, words in (
            ("collision_rate", "the two collide"),
            ("goal_rate_robot", "the robot reaches its goal"),
            ("goal_rate_human", "the human reaches its own"),
        )
        if (rate := run.estimate(metric)) is not None
        for marl in [group.reference(f"truth_{metric}")]
    ]
    if rates:
        sentences.append(f"In the encounters of the robot of {label}, {', '.join(rates)}.")
    error = run.estimate("human_goal_error")
    if error is not None:
        radius = group.game.get("goal_radius")
        told = "" if radius is None else f"; the goal has radius {format_number(radius)}"
        sentences.append(f"{label} places the human's goal {error} from where it is{told}.")
    return sentences


def _deception_verdict(label: str, run: ReportedRun) -> list[str]:
    preference = run.final.get("target_preference")
    if preference is None:
        return []
    right = int((preference > 0).sum())
    return [
        f"That the adversary wants to be near its target rather than near the other landmark, {label} found out in "
        f"{right} of {len(preference)} seeds."
    ]


def _misfit(label: str, run: ReportedRun) -> list[str]:
    gap, noise = run.estimate("feature_gap"), run.estimate("feature_gap_noise")
    if gap is None or noise is None:
        return []
    return [
        f"What the learned reward of {label} makes the expert do differs from what the expert did by "
        f"{format_number(gap.mean, 3)} in its features; sampling alone would make {format_number(noise.mean, 3)}."
    ]


def _warnings(label: str, run: ReportedRun) -> list[str]:
    sentences = []
    if run.failed_seeds:
        seeds = ", ".join(map(str, run.failed_seeds))
        word, verb = ("Seed", "is") if len(run.failed_seeds) == 1 else ("Seeds", "are")
        sentences.append(
            f"{word} {seeds} of {label} failed (not finite, or worse than random play) and {verb} left out of every "
            f"figure and mean; {len(run.kept_seeds)} of {len(run.seeds)} remain."
        )
    broken = {
        metric: run.not_finite(metric) for metric in run.metrics.columns if metric in METRICS or "_return_" in metric
    }
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
