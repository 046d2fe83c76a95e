"""The figures of physical deception, and the words around them."""

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.deception import BODIES, advantage, targets, true_weights
from gsiirl.report.deception_figure import animate_deception, draw_deception
from gsiirl.report.figure_style import picture
from gsiirl.report.group import GameGroup
from gsiirl.report.page_figure import PageFigure
from gsiirl.report.plane_episode import PlaneEpisode, pick_episode
from gsiirl.report.run import ReportedRun
from gsiirl.report.weights_figure import draw_weights


def deception_figures(
    group: GameGroup, shown: ReportedRun | None, returns: PageFigure | None
) -> list[PageFigure | None]:
    """In the page's order, the figure of the returns among them."""
    episode = None if shown is None else pick_episode(shown, BODIES, advantage)
    name = "" if shown is None else algorithm_style(shown.algorithm).name
    return [
        episode and _animation(group, episode, name),
        returns,
        _weights(group),
        episode and _episode(group, episode, name),
    ]


def _animation(group: GameGroup, episode: PlaneEpisode, name: str) -> PageFigure:
    target, expert_target = targets(episode)
    wants = (
        "wants to be near it as well, but does not know which of the two landmarks it is: it can only guess from what "
        "the others do"
        if target == expert_target
        else "is after the other landmark"
    )
    return PageFigure(
        f"{group.key}-animation",
        "One episode, as it happens",
        f"Two good agents ({name}) want one of them near the target and the adversary far from it. The real adversary "
        f"{wants}. {_choice(episode)}",
        "Two good agents and an adversary among two landmarks, step by step",
        animate_deception(episode),
    )


def _weights(group: GameGroup) -> PageFigure | None:
    truth = true_weights(group.game, group.first.path)
    figure = draw_weights(group, truth)
    told = "; the black line is the true weight" if truth else ""
    return figure and PageFigure(
        f"{group.key}-weights",
        "What the good agents think that the adversary wants",
        f"Weights of the adversary's reward by feature, mean and standard deviation over seeds{told}. A bar to the "
        "left: the adversary wants less of it. A reward times a positive number wants the same, so every one is scaled "
        "to length 1.",
        "Learned weights of the adversary's reward",
        picture(figure),
    )


def _episode(group: GameGroup, episode: PlaneEpisode, name: str) -> PageFigure:
    return PageFigure(
        f"{group.key}-path",
        "The same episode at a glance",
        f"Left, every dot is a step, hollow where a body starts. Right, the good agents ({name}, seed {episode.seed}) "
        f"do well while the red line is above the green one. {_choice(episode)}",
        "Ways of the good agents and the adversary, and their distances to the target over time",
        picture(draw_deception(episode)),
    )


def _choice(episode: PlaneEpisode) -> str:
    return (
        f"Of {episode.recorded} recorded episodes this is the one in which the good agents' advantage (how much nearer "
        "to the target than the adversary they are, mean over the steps) is the median: neither the best nor the worst."
    )
