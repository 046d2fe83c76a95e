"""The figures of the crossing, with their words."""

from gsiirl.report.crossing.encounter_figure import animate_encounter, draw_encounter, smallest_distance
from gsiirl.report.crossing.rates_figure import draw_rates, rates_panels
from gsiirl.report.crossing.recorded_crossing import RecordedCrossing
from gsiirl.report.crossing.reward_map import RewardMap
from gsiirl.report.crossing.reward_map_figure import draw_reward_map
from gsiirl.report.curves.charts import charts_of
from gsiirl.report.figures.page_figure import PageFigure, page_figure
from gsiirl.report.plane.episode import pick_episode
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.words.algorithms import algorithm_style
from gsiirl.report.words.sentences import counted


def crossing_figures(group: GameGroup, shown: ReportedRun | None) -> list[PageFigure | None]:
    """The figures of one game in the page's order; `shown` is the run whose encounter and reward they show."""
    crossing = RecordedCrossing.read(group.game, group.first.path)
    animation, glance = (None, None) if shown is None else _encounter(group, crossing, shown)
    return [None if shown is None else _reward_map(group, crossing, shown), animation, _rates(group), glance]


def _encounter(
    group: GameGroup, crossing: RecordedCrossing, shown: ReportedRun
) -> tuple[PageFigure | None, PageFigure | None]:
    """The animation of one encounter, and the same encounter in one picture."""
    episode = pick_episode(shown, ("robot", "human"), smallest_distance)
    if episode is None:
        return None, None
    name, choice = algorithm_style(shown.algorithm).name, episode.choice("encounters", "whose smallest distance")
    animation = page_figure(
        f"{group.key}-animation",
        "One encounter, as it happens",
        f"The robot that learned ({name}) meets the real human. It wants to be at its own goal soon and the human at "
        "ease: the dashed ring is the distance that it should keep, red while the human is nearer. It was never told "
        f"where the human wants to go. {choice}",
        "Robot and human cross each other's way, step by step",
        animate_encounter(crossing, episode),
    )
    glance = page_figure(
        f"{group.key}-path",
        "The same encounter at a glance",
        f"Left, every dot is a step, and the dotted line joins the two where they were nearest. Right, their distance: "
        f"it should stay above the dashed line ({name}, seed {episode.seed}). {choice}",
        "Ways of robot and human, and their distance over time",
        draw_encounter(crossing, episode),
    )
    return animation, glance


def _rates(group: GameGroup) -> PageFigure | None:
    panels = rates_panels(group)
    return page_figure(
        f"{group.key}-rates",
        "Do they collide, and do they arrive?",
        "Shares of the encounters of the learned robot with the real human. Few collisions and many arrivals are "
        f"good. Lines are means over seeds, bands one standard deviation.{group.exploring}",
        "Rates of collisions and of reached goals along the iterations",
        draw_rates(group),
        charts_of(group, panels, panels[0].levels if panels else []),
    )


def _reward_map(group: GameGroup, crossing: RecordedCrossing, shown: ReportedRun) -> PageFigure | None:
    rewards = RewardMap.of(shown)
    return rewards and page_figure(
        f"{group.key}-reward-map",
        "Where does the human want to be?",
        "The human's reward of a step by where the human is, the robot being far away: the stronger the colour, the "
        f"better. The robot ({algorithm_style(shown.algorithm).name}, mean over {counted(len(rewards.peaks), 'seed')}) "
        "has found the goal if the circle lies on the star. Only differences count, so both maps run from their own "
        "lowest to their own highest value.",
        "The human's reward over the plane, learned and true",
        draw_reward_map(crossing, rewards),
    )
