"""The figures of physical deception, with their words."""

from gsiirl.report.deception.episode_figure import animate_episode, draw_episode
from gsiirl.report.deception.recorded_episode import BODIES, advantage, targets, true_weights
from gsiirl.report.deception.weights_figure import draw_weights
from gsiirl.report.figures.page_figure import PageFigure, page_figure
from gsiirl.report.plane.episode import pick_episode
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.words.algorithms import algorithm_style

MEASURE = (
    "in which the good agents' advantage (how much nearer to the target than the adversary they are, mean over the "
    "steps)"
)


def deception_figures(group: GameGroup, shown: ReportedRun | None) -> list[PageFigure | None]:
    """The figures of one game in the page's order; `shown` is the run whose episode they show."""
    animation, glance = (None, None) if shown is None else _episode(group, shown)
    return [_weights(group), animation, glance]


def _episode(group: GameGroup, shown: ReportedRun) -> tuple[PageFigure | None, PageFigure | None]:
    """The animation of one episode, and the same episode in one picture."""
    episode = pick_episode(shown, BODIES, advantage)
    if episode is None:
        return None, None
    name, choice = algorithm_style(shown.algorithm).name, episode.choice("episodes", MEASURE)
    target, expert_target = targets(episode)
    wants = (
        "wants to be near it as well, but does not know which of the two landmarks it is: it can only guess from what "
        "the others do"
        if target == expert_target
        else "is after the other landmark"
    )
    animation = page_figure(
        f"{group.key}-animation",
        "One episode, as it happens",
        f"Two good agents ({name}) want one of them near the target and the adversary far from it. The real adversary "
        f"{wants}. {choice}",
        "Two good agents and an adversary among two landmarks, step by step",
        animate_episode(episode),
    )
    glance = page_figure(
        f"{group.key}-path",
        "The same episode at a glance",
        f"Left, every dot is a step, hollow where a body starts. Right, the good agents ({name}, seed {episode.seed}) "
        f"do well while the red line is above the green one. {choice}",
        "Ways of the good agents and the adversary, and their distances to the target over time",
        draw_episode(episode),
    )
    return animation, glance


def _weights(group: GameGroup) -> PageFigure | None:
    truth = true_weights(group.game, group.first.path)
    told = "; the upright line is the true weight" if truth else ""
    return page_figure(
        f"{group.key}-weights",
        "What the good agents think that the adversary wants",
        f"Weights of the adversary's reward by feature, mean and standard deviation over seeds{told}. A bar to the "
        "left: the adversary wants less of it. A reward times a positive number wants the same, so every one is scaled "
        "to length 1.",
        "Learned weights of the adversary's reward",
        draw_weights(group, truth),
    )
