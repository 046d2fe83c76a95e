"""What the figures say, in sentences computed from them."""

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.estimate import Estimate, format_number
from gsiirl.report.group import GameGroup
from gsiirl.report.returns_figure import reference
from gsiirl.report.run import ReportedRun


def verdicts(group: GameGroup) -> list[str]:
    """The sentences of one game, most important first."""
    learners = [(label, run) for label, run in group.runs.items() if run.algorithm != "marl" and run.kept_seeds]
    # The algorithm of the project comes first, then what it is compared with.
    learners.sort(key=lambda each: each[1].algorithm != "gsiirl")
    sentences = []
    for place, (label, run) in enumerate(learners):
        sentences += _return_verdict(group, label, run, full=place == 0)
    for label, run in learners:
        sentences += _reward_verdict(group, label, run)
    for label, run in group.runs.items():
        sentences += _warnings(label, run)
    return sentences


def _return_verdict(group: GameGroup, label: str, run: ReportedRun, full: bool) -> list[str]:
    ends = run.estimate("deployed_return_learner")
    marl, random = reference(group, "truth", "learner"), reference(group, "random", "learner")
    if ends is None:
        return []
    learner, expert = group.sides
    text = f"The {learner} that {_how(run.algorithm, label)} ends at {ends}"
    if full:
        text += f" against the real {expert}"
        if marl is not None:
            text += f"; MARL, which was given both rewards, at {format_number(marl)}"
        if random is not None:
            text += f"; a {learner} that plays at random, at {format_number(random)}"
        text += ". Higher is better" if marl is None else ". Higher is better: it does"
    elif marl is not None:
        text += ":"
    return [f"{text}." if marl is None else f"{text} {_comparison(ends, marl)}."]


def _how(algorithm: str, label: str) -> str:
    if algorithm == "gsiirl":
        return f"learned by interacting ({label})"
    if algorithm == "ma-irl":
        return f"learned from fixed demonstrations ({label})"
    return f"learned with {label}"


def _comparison(ends: Estimate, marl: float) -> str:
    if ends.count > 1 and ends.low <= marl <= ends.high:
        return "neither better nor worse than MARL (which lies within the 95 % interval)"
    return "better than MARL" if ends.mean > marl else "worse than MARL"


def _reward_verdict(group: GameGroup, label: str, run: ReportedRun) -> list[str]:
    pearson = run.estimate("expert_reward_pearson")
    if pearson is None:
        return []
    _, expert = group.sides
    asked = run.estimate("expert_trajectories")
    cost = f", after {asked.mean:.0f} observed trajectories a seed" if asked is not None else ""
    return [
        f"The {expert}'s reward as {label} learned it correlates {format_number(pearson.mean, 3)} with the true one "
        f"(1 is perfect){cost}."
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
    if not run.completed:
        sentences.append(
            f"The run of {algorithm_style(run.algorithm).name} in {run.path.name} was interrupted: shown as far as "
            f"iteration {run.iterations}; gsiirl resume goes on with it."
        )
    return sentences
