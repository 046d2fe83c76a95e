"""True against learned reward weights, and how well they agree along the iterations."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.attack_graph import AttackGraph
from gsiirl.report.figure_style import FAINT_COLOUR
from gsiirl.report.group import GameGroup

Series = tuple[str, str, np.ndarray, np.ndarray]
"""Label, colour, true weights [features], learned weights [seeds, features]."""


def draw_recovery(group: GameGroup, graph: AttackGraph) -> Figure | None:
    """Scatter plots (attacker's values and costs, defender's losses) and Pearson; None if nothing was learned.

    Footholds are left out: they cannot be taken, so what they are worth has no effect and cannot be learned.
    """
    count = len(graph.nodes)
    nodes = np.flatnonzero(~np.array(graph.footholds))
    edges = np.arange(count, count + len(graph.edges))
    costs = list(_series(group, "expert_reward", graph.expert_truth, edges, ""))
    panels = [
        (
            "What each node is worth to the attacker",
            list(_series(group, "expert_reward", graph.expert_truth, nodes, "")),
        ),
        (
            f"What each attack costs the attacker{'' if graph.expert_no_op else '*'}",
            [_up_to_a_constant(*series) if not graph.expert_no_op else series for series in costs],
        ),
        (
            "What the attacker costs the defender",
            [
                *_series(group, "dependent_reward", graph.dependent_truth, nodes, ", losses"),
                *_series(group, "dependent_reward", graph.dependent_truth, edges, ", attacks"),
            ],
        ),
    ]
    panels = [(title, series) for title, series in panels if series]
    if not panels:
        return None
    figure = Figure(figsize=(9.6, 8.4), layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    for panel, (title, series) in zip(axes, panels, strict=False):
        _draw_scatter(panel, title, series)
    _draw_pearson(axes[len(panels)], group)
    if not graph.expert_no_op:
        figure.supxlabel(
            "* up to a common constant: an attacker that must attack something pays some cost every step, "
            "so their mean cannot be learned",
            fontsize=9,
        )
    for empty in axes[len(panels) + 1 :]:
        empty.set_axis_off()
    return figure


def _series(group: GameGroup, parameter: str, truth: np.ndarray, part: np.ndarray, suffix: str) -> Iterator[Series]:
    for label, run in group.runs.items():
        weights = run.weights(parameter)
        if weights is not None and weights.shape[1] >= len(truth):
            yield label + suffix, algorithm_style(run.algorithm).colour, truth[part], weights[:, part]


def _up_to_a_constant(label: str, colour: str, true: np.ndarray, learned: np.ndarray) -> Series:
    """The same with each seed's mean moved onto the true mean.

    An attacker that cannot abstain pays one of its costs every step, whatever it does: nobody can learn their mean.
    """
    return label, colour, true, learned - learned.mean(axis=1, keepdims=True) + true.mean()


def _draw_scatter(panel: Axes, title: str, series: list[Series]) -> None:
    extremes: list[float] = [0.0]
    for label, colour, true, weights in series:
        mean, std = weights.mean(axis=0), weights.std(axis=0, ddof=1) if len(weights) > 1 else np.zeros(len(true))
        hollow = label.endswith("attacks")
        panel.errorbar(
            true,
            mean,
            yerr=std,
            fmt="s" if hollow else "o",
            markersize=5 if hollow else 7,
            markerfacecolor="white" if hollow else colour,
            color=colour,
            alpha=0.85,
            elinewidth=1.2,
            label=label,
        )
        extremes += [*true.tolist(), *(mean - std).tolist(), *(mean + std).tolist()]
    low, high = min(extremes), max(extremes)
    margin = 0.06 * (high - low or 1.0)
    ends = (low - margin, high + margin)
    panel.plot(ends, ends, color=FAINT_COLOUR, linewidth=1, linestyle="--", zorder=1, label="learned = true")
    panel.set(xlim=ends, ylim=ends, aspect="equal", xlabel="true weight", ylabel="learned weight", title=title)
    panel.legend(loc="upper left", fontsize=9)


def _draw_pearson(panel: Axes, group: GameGroup) -> None:
    for label, run in group.runs.items():
        colour = algorithm_style(run.algorithm).colour
        for metric, whose, style in (
            ("expert_reward_pearson", "attacker's reward", "-"),
            ("dependent_reward_pearson", "defender's dependent reward", "--"),
        ):
            curve = run.curve(metric)
            if curve is None:
                continue
            low, high = curve.mean - curve.std, curve.mean + curve.std
            panel.fill_between(curve.iteration, low, high, color=colour, alpha=0.15, linewidth=0)
            panel.plot(curve.iteration, curve.mean, style, color=colour, linewidth=2, label=f"{label}, {whose}")
    panel.axhline(1.0, color=FAINT_COLOUR, linewidth=1, linestyle=":")
    panel.set(
        xlabel="iteration", ylabel="Pearson correlation with the truth", title="Agreement with the truth (1: perfect)"
    )
    panel.margins(x=0.02)
    panel.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    if panel.get_legend_handles_labels()[0]:
        panel.legend(loc="lower right", fontsize=9)
