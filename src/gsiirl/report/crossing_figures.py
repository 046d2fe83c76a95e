"""The figures of the crossing, and the words around them."""

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.crossing import Crossing
from gsiirl.report.crossing_figure import animate_crossing, closeness, draw_crossing
from gsiirl.report.figure_style import picture
from gsiirl.report.group import GameGroup
from gsiirl.report.page_figure import PageFigure
from gsiirl.report.plane_episode import PlaneEpisode, pick_episode
from gsiirl.report.rates_figure import draw_rates
from gsiirl.report.reward_map import RewardMap
from gsiirl.report.reward_map_figure import draw_reward_map
from gsiirl.report.run import ReportedRun


def crossing_figures(
    group: GameGroup, shown: ReportedRun | None, returns: PageFigure | None
) -> list[PageFigure | None]:
    """In the page's order, the figure of the returns among them."""
    crossing = Crossing.read(group.game, group.first.path)
    episode = None if shown is None else pick_episode(shown, ("robot", "human"), closeness)
    rewards = None if shown is None else RewardMap.of(shown)
    name = "" if shown is None else algorithm_style(shown.algorithm).name
    return [
        episode and _animation(group, crossing, episode, name),
        returns,
        _rates(group),
        rewards and _reward_map(group, crossing, rewards, name),
        episode and _encounter(group, crossing, episode, name),
    ]


def _animation(group: GameGroup, crossing: Crossing, episode: PlaneEpisode, name: str) -> PageFigure:
    return PageFigure(
        f"{group.key}-animation",
        "One encounter, as it happens",
        f"The robot that learned ({name}) meets the real human. It wants to be at its own goal soon and the human at "
        "ease: the dashed ring is the distance that it should keep, red while the human is nearer. It was never told "
        f"where the human wants to go. {_choice(episode)}",
        "Robot and human cross each other's way, step by step",
        animate_crossing(crossing, episode),
    )


def _rates(group: GameGroup) -> PageFigure | None:
    figure = draw_rates(group)
    return figure and PageFigure(
        f"{group.key}-rates",
        "Do they collide, and do they arrive?",
        "Shares of the encounters of the learned robot with the real human. Few collisions and many arrivals are "
        f"good. Lines are means over seeds, bands one standard deviation.{group.exploring}",
        "Rates of collisions and of reached goals along the iterations",
        picture(figure),
    )


def _reward_map(group: GameGroup, crossing: Crossing, rewards: RewardMap, name: str) -> PageFigure:
    return PageFigure(
        f"{group.key}-reward-map",
        "Where does the human want to be?",
        f"The human's reward of a step by where the human is, the robot being far away: the darker, the better. The "
        f"robot ({name}, mean over {len(rewards.peaks)} seeds) has found the goal if the circle lies on the star. "
        "Only differences count, so both maps run from their own lowest to their own highest value.",
        "The human's reward over the plane, learned and true",
        picture(draw_reward_map(crossing, rewards)),
    )


def _encounter(group: GameGroup, crossing: Crossing, episode: PlaneEpisode, name: str) -> PageFigure:
    return PageFigure(
        f"{group.key}-path",
        "The same encounter at a glance",
        f"Left, every dot is a step, and the dotted line joins the two where they were nearest. Right, their distance: "
        f"it should stay above the dashed line ({name}, seed {episode.seed}). {_choice(episode)}",
        "Ways of robot and human, and their distance over time",
        picture(draw_crossing(crossing, episode)),
    )


def _choice(episode: PlaneEpisode) -> str:
    return (
        f"Of {episode.recorded} recorded encounters this is the one whose smallest distance is the median: neither "
        "the best nor the worst."
    )
