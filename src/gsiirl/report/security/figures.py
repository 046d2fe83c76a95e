"""The figures of an attack graph, with their words."""

from gsiirl.report.figures.page_figure import PageFigure, page_figure
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.security.graph_figure import draw_attack_graph
from gsiirl.report.security.host_names import are_numbered, with_short_names
from gsiirl.report.security.network_table import untested_hosts
from gsiirl.report.security.recorded_graph import RecordedGraph
from gsiirl.report.security.recovery_figure import draw_recovery
from gsiirl.report.security.sample_path import SamplePath, pick_sample_path
from gsiirl.report.security.sample_path_figure import draw_sample_path
from gsiirl.report.words.algorithms import algorithm_style
from gsiirl.report.words.sentences import counted


def security_figures(group: GameGroup, shown: ReportedRun | None) -> list[PageFigure | None]:
    """The figures of one game in the page's order; `shown` is the run whose learned values and trajectory they show."""
    whole = RecordedGraph.read(group.game, group.first.path)
    graph = with_short_names(whole)
    network = _attack_graph(group, graph, shown, are_numbered(whole.nodes))
    return [network, _recovery(group, graph), _sample_path(group, graph, shown)]


def _attack_graph(
    group: GameGroup, graph: RecordedGraph, shown: ReportedRun | None, numbered: bool
) -> PageFigure | None:
    weights = None if shown is None else shown.weights("expert_reward")
    values = None if weights is None else weights.mean(axis=0)[: len(graph.nodes)]
    caption = (
        "Each box is a machine, each arrow an attack that can lead from one to the next. The attacker works from left "
        "to right; the defender sees it all and blocks one arrow a step."
    )
    if shown is not None and values is not None:
        caption += (
            f" The two bars of a box compare what the machine is truly worth to the attacker with what "
            f"{algorithm_style(shown.algorithm).name} learned (mean over {counted(len(shown.kept_seeds), 'seed')}): "
            "equal bars, well learned."
        )
    untested = [] if shown is None else untested_hosts(graph, shown)
    if untested:
        caption += " Pale: learned without ever having been put to the test."
    if numbered:
        caption += " The machines are numbered; their whole names are in the table below."
    return page_figure(
        f"{group.key}-attack-graph",
        "The network, and what the defender learned about its attacker",
        caption,
        "Attack graph with the true and the learned value of every node",
        draw_attack_graph(graph, values, untested),
    )


def _recovery(group: GameGroup, graph: RecordedGraph) -> PageFigure | None:
    return page_figure(
        f"{group.key}-recovery",
        "Are the learned rewards the true ones?",
        "Each point is one weight of a reward: on the diagonal it was learned exactly. "
        f"{_bars(group)} Machines that can never fall are left out: what they are worth has no effect. The last panel "
        "follows the agreement along the iterations.",
        "Learned against true reward weights, and their correlation along the iterations",
        draw_recovery(group, graph),
    )


def _bars(group: GameGroup) -> str:
    """What the bars of the recovery figure are."""
    deviation = "the standard deviation over seeds"
    drawn = [label for label, run in group.runs.items() if run.expert_draws is not None]
    if not drawn:
        return f"Bars are {deviation}."
    return (
        f"Bars of the attacker's weights by {' and '.join(drawn)} are where a weight lies with 90 %, as one seed "
        f"knows it; the other bars are {deviation}. Grey and hollow: not determined by what was seen."
    )


def _sample_path(group: GameGroup, graph: RecordedGraph, shown: ReportedRun | None) -> PageFigure | None:
    path = None if shown is None else pick_sample_path(graph, shown)
    if shown is None or path is None:
        return None
    return page_figure(
        f"{group.key}-path",
        "One encounter, step by step",
        f"The learned defender ({algorithm_style(shown.algorithm).name}, seed {path.seed}) against the real attacker. "
        "Red cells are machines in the attacker's hands after the step. No effect: an attack that could not succeed, "
        f"since its source is not held or its target already is{_idle(graph)}. Of {path.recorded} recorded encounters "
        "this is the one in which most machines fall."
        f"{_end(path)}",
        "Timeline of one trajectory: attacks, blocks and compromised nodes",
        draw_sample_path(graph, path),
    )


def _idle(graph: RecordedGraph) -> str:
    """Why an attacker attacks in vain."""
    if graph.expert_no_op:
        return "; an attacker that is not perfectly rational tries such a one now and then, though it might wait"
    return "; an attacker that has nothing to gain but must attack something picks such a one"


def _end(path: SamplePath) -> str:
    """What the last step's word means, where what came of it is not known."""
    unknown = any(step.outcome == "unknown" for step in path.steps)
    return " End: what came of the last step's attack is not recorded." if unknown else ""
