"""Every machine and every attack of a network: the true weight, the learned one, and whether it was put to the test."""

from dataclasses import dataclass

import numpy as np

from gsiirl.report.read.run import ReportedRun
from gsiirl.report.security.host_names import are_numbered
from gsiirl.report.security.recorded_graph import OUTSIDE, RecordedGraph
from gsiirl.report.words.algorithms import algorithm_style
from gsiirl.report.words.numbers import default_digits, format_number

DASH = "\N{EN DASH}"
NOT_RECORDED = "not recorded"


@dataclass(frozen=True)
class WeightRow:
    """A machine with its value to the attacker, or an attack with its cost."""

    name: str
    number: str
    """As the figures number it; of an attack those of its two ends; empty where names are whole there."""
    true: str
    learned: str
    tested: str
    """How often interactions put it to the test, in words."""
    sure: bool
    """Whether the learned weight rests on observations."""


@dataclass(frozen=True)
class NetworkTable:
    """All machines and attacks of one network."""

    hosts: list[WeightRow]
    edges: list[WeightRow]
    learner: str
    """Whose learned weights these are; empty where nothing was learned."""
    numbered: bool
    """Whether figures number the machines."""
    only_differences: bool
    """Whether costs can be learned up to a common constant only: they are shifted to the mean of the true ones."""


def network_table(graph: RecordedGraph, run: ReportedRun | None) -> NetworkTable:
    """The table of a network, with what a run learned of it."""
    learned = None if run is None else _mean(run, "expert_reward", len(graph.nodes) + len(graph.edges))
    attacks, chances = (None if run is None else _mean(run, name, len(graph.edges)) for name in ("attacks", "chances"))
    count, numbered = len(graph.nodes), are_numbered(graph.nodes)
    if learned is not None and not graph.expert_no_op:
        # As in the figure: their mean cannot be learned.
        learned[count:] += graph.expert_truth[count:].mean() - learned[count:].mean()
    untested = [] if run is None else untested_hosts(graph, run)
    digits = default_digits(float(np.abs(graph.expert_truth).max()))
    hosts = [
        WeightRow(
            name=name,
            number=str(node + 1) if numbered else "",
            true=format_number(float(graph.expert_truth[node]), digits),
            learned=_learned(learned, node, digits) if graph.can_fall(node) else DASH,
            tested=_host_tested(graph, node, chances),
            sure=graph.can_fall(node) and node not in untested,
        )
        for node, name in enumerate(graph.nodes)
    ]
    edges = [
        WeightRow(
            name=graph.edge_name(edge),
            number=_ends(*ends) if numbered else "",
            true=format_number(float(graph.expert_truth[count + edge]), digits),
            learned=_learned(learned, count + edge, digits),
            tested=_edge_tested(graph, edge, attacks, chances),
            sure=attacks is None or bool(attacks[edge] > 0),
        )
        for edge, ends in enumerate(graph.edges)
    ]
    learner = "" if run is None or learned is None else algorithm_style(run.algorithm).name
    return NetworkTable(hosts, edges, learner, numbered, not graph.expert_no_op)


def untested_hosts(graph: RecordedGraph, run: ReportedRun) -> list[int]:
    """The machines that can fall and that no attack with a chance was ever seen at; [] where none is recorded."""
    chances = _mean(run, "chances", len(graph.edges))
    if chances is None:
        return []
    return [node for node in range(len(graph.nodes)) if graph.can_fall(node) and not _chances_at(graph, node, chances)]


def _chances_at(graph: RecordedGraph, node: int, chances: np.ndarray) -> float:
    """Attacks at a node, from anywhere, that had a chance."""
    return float(sum(chances[edge] for edge, (_, target) in enumerate(graph.edges) if target == node))


def _mean(run: ReportedRun, name: str, count: int) -> np.ndarray | None:
    """The mean over seeds of what was learned, or counted, of `count` things; None where the run has none of them."""
    weights = run.weights(name)
    return None if weights is None or weights.shape[1] != count else weights.mean(axis=0)


def _learned(learned: np.ndarray | None, place: int, digits: int) -> str:
    return DASH if learned is None else format_number(float(learned[place]), digits)


def _ends(source: int, target: int) -> str:
    return f"{'outside' if source == OUTSIDE else source + 1} \N{RIGHTWARDS ARROW} {target + 1}"


def _host_tested(graph: RecordedGraph, node: int, chances: np.ndarray | None) -> str:
    if graph.footholds[node]:
        return "held from the start: its value has no effect"
    if not graph.can_fall(node):
        return "cannot be reached: its value has no effect"
    if chances is None:
        return NOT_RECORDED
    count = _chances_at(graph, node, chances)
    return f"{_attacks(count)} with a chance" if count > 0 else "never"


def _edge_tested(graph: RecordedGraph, edge: int, attacks: np.ndarray | None, chances: np.ndarray | None) -> str:
    hopeless = "" if graph.can_be_attacked(edge) else "; it can never succeed"
    if attacks is None or chances is None:
        return NOT_RECORDED + hopeless
    if not attacks[edge] > 0:
        return "never" + hopeless
    with_a_chance = "" if hopeless else f", {_number(float(chances[edge]))} with a chance"
    return f"{_attacks(float(attacks[edge]))}{with_a_chance}{hopeless}"


def _attacks(count: float) -> str:
    return f"{_number(count)} attack{'s' * (_number(count) != '1')}"


def _number(count: float) -> str:
    """A mean number over seeds."""
    return "below 1" if 0 < count < 0.95 else f"{count:,.0f}"
