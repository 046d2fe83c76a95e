"""The figures of an attack graph, and the words around them."""

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.attack_graph import AttackGraph
from gsiirl.report.attack_graph_figure import draw_attack_graph
from gsiirl.report.figure_style import picture
from gsiirl.report.group import GameGroup
from gsiirl.report.page_figure import PageFigure
from gsiirl.report.recovery_figure import draw_recovery
from gsiirl.report.run import ReportedRun
from gsiirl.report.sample_path import pick_sample_path
from gsiirl.report.sample_path_figure import draw_sample_path


def security_figures(
    group: GameGroup, shown: ReportedRun | None, returns: PageFigure | None
) -> list[PageFigure | None]:
    """In the page's order, the figure of the returns among them."""
    graph = AttackGraph.read(group.game, group.first.path)
    return [
        _attack_graph(group, graph, shown),
        returns,
        _recovery(group, graph),
        _sample_path(group, graph, shown),
    ]


def _attack_graph(group: GameGroup, graph: AttackGraph, shown: ReportedRun | None) -> PageFigure:
    weights = None if shown is None else shown.weights("expert_reward")
    values = None if weights is None else weights.mean(axis=0)[: len(graph.nodes)]
    caption = (
        "Each box is a machine, each arrow an attack that can lead from one to the next. The attacker works from left "
        "to right; the defender sees it all and blocks one arrow a step."
    )
    if shown is not None and values is not None:
        caption += (
            f" The two bars of a box compare what the machine is truly worth to the attacker with what "
            f"{algorithm_style(shown.algorithm).name} learned (mean over {len(shown.kept_seeds)} seeds): equal bars, "
            "well learned."
        )
    return PageFigure(
        f"{group.key}-attack-graph",
        "The network, and what the defender learned about its attacker",
        caption,
        "Attack graph with the true and the learned value of every node",
        picture(draw_attack_graph(graph, values)),
    )


def _recovery(group: GameGroup, graph: AttackGraph) -> PageFigure | None:
    figure = draw_recovery(group, graph)
    return figure and PageFigure(
        f"{group.key}-recovery",
        "Are the learned rewards the true ones?",
        "Each point is one weight of a reward, with its standard deviation over seeds: on the diagonal it was learned "
        "exactly. Footholds are left out: what they are worth has no effect. The last panel follows the agreement "
        "along the iterations.",
        "Learned against true reward weights, and their correlation along the iterations",
        picture(figure),
    )


def _sample_path(group: GameGroup, graph: AttackGraph, shown: ReportedRun | None) -> PageFigure | None:
    path = None if shown is None else pick_sample_path(graph, shown)
    if shown is None or path is None:
        return None
    return PageFigure(
        f"{group.key}-path",
        "One encounter, step by step",
        f"The learned defender ({algorithm_style(shown.algorithm).name}, seed {path.seed}) against the real attacker. "
        f"Red cells are machines in the attacker's hands after the step. Of {path.recorded} recorded encounters this "
        "is the one in which most machines fall.",
        "Timeline of one trajectory: attacks, blocks and compromised nodes",
        picture(draw_sample_path(graph, path)),
    )
