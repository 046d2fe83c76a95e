"""The figures of one game, by its kind."""

from collections.abc import Callable

from gsiirl.report.crossing.figures import crossing_figures
from gsiirl.report.curves.charts import charts_of
from gsiirl.report.curves.returns_figure import draw_returns, returns_levels, returns_panels
from gsiirl.report.deception.figures import deception_figures
from gsiirl.report.figures.page_figure import PageFigure, page_figure
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.security.figures import security_figures
from gsiirl.report.security.network_table import NetworkTable, network_table
from gsiirl.report.security.recorded_graph import RecordedGraph

KINDS: dict[str, Callable[[GameGroup, ReportedRun | None], list[PageFigure | None]]] = {
    "attack_graph": security_figures,
    "crossing": crossing_figures,
    "deception": deception_figures,
}
"""By the kind of the game: its own figures in the page's order, given the run to show."""


def draw_figures(group: GameGroup) -> list[PageFigure]:
    """The figures of one game in the page's order: the first two of its own, the returns, the rest of its own."""
    shown = shown_run(group)
    draw = KINDS.get(str(group.game.get("kind")))
    own = [] if draw is None else draw(group, shown)
    return [figure for figure in (*own[:2], _returns(group), *own[2:]) if figure is not None]


def shown_run(group: GameGroup) -> ReportedRun | None:
    """The run whose learned reward and encounters are shown: GSIIRL's, else the first that learned a reward."""
    learned = (run for run in group.runs.values() if run.weights("expert_reward") is not None)
    return group.of("gsiirl") or next(learned, None)


def network_of(group: GameGroup) -> NetworkTable | None:
    """The table of all machines and attacks; None where the game is not one of a network."""
    if group.game.get("kind") != "attack_graph":
        return None
    return network_table(RecordedGraph.read(group.game, group.first.path), shown_run(group))


def _returns(group: GameGroup) -> PageFigure | None:
    learner, expert = group.sides
    return page_figure(
        f"{group.key}-returns",
        "How both sides fare while the learner learns",
        "Lines are means over seeds, bands one standard deviation; what strays far for a while is cut off. "
        f"Look at the upper left panel first: it is what the {learner} really {learner.verb('earns', 'earn')}. "
        f"The higher the curve, the better; the dashed line is MARL's pair as it was trained with both true rewards. "
        f"Deployed: what the learner learned, against the real {expert}; model: both play what the learner's model "
        f"expects. The right column is what the {expert} earns in the same "
        f"encounters.{group.exploring}",
        f"Returns of {learner} and {expert} along the iterations",
        draw_returns(group),
        charts_of(group, returns_panels(group), returns_levels(group)),
    )
