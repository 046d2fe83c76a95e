"""Which figures a game has."""

from gsiirl.report.crossing_figures import crossing_figures
from gsiirl.report.deception_figures import deception_figures
from gsiirl.report.figure_style import picture
from gsiirl.report.group import GameGroup
from gsiirl.report.page_figure import PageFigure
from gsiirl.report.returns_figure import draw_returns
from gsiirl.report.run import ReportedRun
from gsiirl.report.security_figures import security_figures

KINDS = {"attack_graph": security_figures, "crossing": crossing_figures, "deception": deception_figures}
"""By the kind of the game: its figures in the page's order, given the one of the returns, which every game has."""


def draw_figures(group: GameGroup) -> list[PageFigure]:
    """The figures of one game, in the page's order."""
    shown = group.of("gsiirl") or _first_that_learned(group)
    returns = _returns(group)
    draw = KINDS.get(str(group.game.get("kind")))
    figures = [returns] if draw is None else draw(group, shown, returns)
    return [figure for figure in figures if figure is not None]


def _first_that_learned(group: GameGroup) -> ReportedRun | None:
    return next((run for run in group.runs.values() if run.weights("expert_reward") is not None), None)


def _returns(group: GameGroup) -> PageFigure | None:
    figure = draw_returns(group)
    learner, expert = group.sides
    return figure and PageFigure(
        f"{group.key}-returns",
        "How both sides fare while the learner learns",
        "Lines are means over seeds, bands one standard deviation; what strays far for a while is cut off. "
        f"Look at the upper left panel first: it is what the {learner} really {learner.verb('earns', 'earn')}. "
        f"The higher the curve, the better; the dashed line is MARL, "
        f"which was given both true rewards. The right column is what the {expert} earns in the same "
        f"encounters.{group.exploring}",
        f"Returns of {learner} and {expert} along the iterations",
        picture(figure),
    )
