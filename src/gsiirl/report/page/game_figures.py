"""The figures of one game, by its kind."""

from collections.abc import Callable

from gsiirl.report.crossing.figures import crossing_figures
from gsiirl.report.curves.returns_figure import draw_returns
from gsiirl.report.deception.figures import deception_figures
from gsiirl.report.figures.page_figure import PageFigure, page_figure
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.security.figures import security_figures

KINDS: dict[str, Callable[[GameGroup, ReportedRun | None], list[PageFigure | None]]] = {
    "attack_graph": security_figures,
    "crossing": crossing_figures,
    "deception": deception_figures,
}
"""By the kind of the game: its own figures in the page's order, given the run to show."""


def draw_figures(group: GameGroup) -> list[PageFigure]:
    """The figures of one game in the page's order: the first of its own, the returns, the rest of its own."""
    shown = group.of("gsiirl") or _first_that_learned(group)
    draw = KINDS.get(str(group.game.get("kind")))
    own = [] if draw is None else draw(group, shown)
    return [figure for figure in (*own[:1], _returns(group), *own[1:]) if figure is not None]


def _first_that_learned(group: GameGroup) -> ReportedRun | None:
    return next((run for run in group.runs.values() if run.weights("expert_reward") is not None), None)


def _returns(group: GameGroup) -> PageFigure | None:
    learner, expert = group.sides
    return page_figure(
        f"{group.key}-returns",
        "How both sides fare while the learner learns",
        "Lines are means over seeds, bands one standard deviation; what strays far for a while is cut off. "
        f"Look at the upper left panel first: it is what the {learner} really {learner.verb('earns', 'earn')}. "
        f"The higher the curve, the better; the dashed line is MARL, "
        f"which was given both true rewards. The right column is what the {expert} earns in the same "
        f"encounters.{group.exploring}",
        f"Returns of {learner} and {expert} along the iterations",
        draw_returns(group),
    )
