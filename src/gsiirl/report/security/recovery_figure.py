"""True against learned reward weights, and their correlation over iterations."""

from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gsiirl.report.curves.learning_curves import draw_curve, number_iterations
from gsiirl.report.figures.style import FAINT_COLOUR, Look
from gsiirl.report.read.group import GameGroup
from gsiirl.report.security.recorded_graph import RecordedGraph
from gsiirl.report.words.algorithms import algorithm_style
from gsiirl.runs.learned import DETERMINED, LEVEL, quantiles, share_of_prior

COMMON_CONSTANT = (
    "* up to a common constant: an attacker that must attack something pays some cost every step, "
    "so their mean cannot be learned"
)

UNDETERMINED_COLOUR = "#94a3b8"


@dataclass(frozen=True)
class _Series:
    """The weights of one run in one scatter plot."""

    label: str
    colour: str
    true: np.ndarray
    """[features]"""
    learned: np.ndarray
    """[seeds, features]"""
    hollow: bool = False
    draws: np.ndarray | None = None
    """[seeds, draws, features], from the posterior; None where there is none."""
    prior: np.ndarray | None = None
    """[seeds], the standard deviation of the prior."""

    @property
    def bars(self) -> np.ndarray:
        """[2, features]: how far the bar of the mean goes down and up.

        The 90 % interval of a seed, on average over seeds; where there is no posterior the deviation over seeds.
        """
        if self.draws is None:
            seeds = len(self.learned)
            return np.broadcast_to(self.learned.std(axis=0, ddof=1) if seeds > 1 else 0.0, (2, len(self.true)))
        low, high = quantiles(self.draws, LEVEL, axis=1)
        return np.maximum([(self.learned - low).mean(axis=0), (high - self.learned).mean(axis=0)], 0.0)

    @property
    def determined(self) -> np.ndarray:
        """[features]: whether most seeds determined the weight; all of them where there is no posterior."""
        if self.draws is None or self.prior is None:
            return np.ones(len(self.true), bool)
        return np.median(share_of_prior(self.draws, self.prior), axis=0) <= DETERMINED


def draw_recovery(group: GameGroup, graph: RecordedGraph) -> Figure | None:
    """Scatter plots (attacker's values and costs, defender's losses) and Pearson; None if nothing was learned.

    Machines that can never fall (footholds, and what no attack reaches) are left out: their value has no effect.
    """
    count = len(graph.nodes)
    nodes = np.flatnonzero([graph.can_fall(node) for node in range(count)])
    edges = np.arange(count, count + len(graph.edges))
    costs = _series(group, "expert_reward", graph.expert_truth, edges)
    if not graph.expert_no_op:
        costs = [_up_to_a_constant(each) for each in costs]
    losses = _series(group, "dependent_reward", graph.dependent_truth, nodes, ", losses")
    attacks = _series(group, "dependent_reward", graph.dependent_truth, edges, ", attacks", hollow=True)
    panels = {
        "What each node is worth to the attacker": _series(group, "expert_reward", graph.expert_truth, nodes),
        f"What each attack costs the attacker{'' if graph.expert_no_op else '*'}": costs,
        "What the attacker costs the defender": losses + attacks,
    }
    panels = {title: series for title, series in panels.items() if series}
    if not panels:
        return None
    figure = Figure(figsize=(9.6, 8.4), layout="constrained")
    *scatters, pearson = figure.subplots(2, 2).ravel()[: len(panels) + 1]
    for panel, (title, series) in zip(scatters, panels.items(), strict=True):
        _draw_scatter(panel, title, series)
    _draw_pearson(pearson, group)
    if not graph.expert_no_op:
        figure.supxlabel(COMMON_CONSTANT, fontsize=9)
    for empty in figure.axes[len(panels) + 1 :]:
        empty.set_axis_off()
    return figure


def _series(
    group: GameGroup, parameter: str, truth: np.ndarray, part: np.ndarray, suffix: str = "", hollow: bool = False
) -> list[_Series]:
    """The features in `part` of every run that learned all features of `truth`."""
    series: list[_Series] = []
    for label, run in group.runs.items():
        learned, colour = run.weights(parameter), algorithm_style(run.algorithm).colour
        if learned is None or learned.shape[1] < len(truth):
            continue
        draws = run.expert_draws if parameter == "expert_reward" else None
        series.append(
            _Series(
                label + suffix,
                colour,
                truth[part],
                learned[:, part],
                hollow,
                None if draws is None else draws[:, :, part],
                run.prior_deviation,
            )
        )
    return series


def _up_to_a_constant(series: _Series) -> _Series:
    """The series with each seed's mean moved onto the true mean.

    An attacker that cannot abstain pays one of its costs every step, whatever it does: nobody can learn their mean.
    """

    def moved(weights: np.ndarray) -> np.ndarray:
        return weights - weights.mean(axis=-1, keepdims=True) + series.true.mean()

    draws = None if series.draws is None else moved(series.draws)
    return replace(series, learned=moved(series.learned), draws=draws)


def _draw_scatter(panel: Axes, title: str, series: list[_Series]) -> None:
    extremes: list[float] = [0.0]
    for each in series:
        mean, bars, known = each.learned.mean(axis=0), each.bars, each.determined
        look: Look = {"fmt": "s", "markersize": 5} if each.hollow else {"fmt": "o", "markersize": 7}
        look |= {"color": each.colour, "markerfacecolor": "white" if each.hollow else each.colour}
        panel.errorbar(
            each.true[known], mean[known], yerr=bars[:, known], alpha=0.85, elinewidth=1.2, label=each.label, **look
        )
        extremes += [*each.true.tolist(), *mean.tolist(), *(mean - bars[0])[known], *(mean + bars[1])[known]]
        if not known.all():
            # Without their bars, which would be as wide as what was thought before anything was seen.
            look |= {"color": UNDETERMINED_COLOUR, "markerfacecolor": "white"}
            panel.errorbar(each.true[~known], mean[~known], label=f"{each.label}, not determined", **look)
    low, high = min(extremes), max(extremes)
    margin = 0.06 * (high - low or 1.0)
    ends = (low - margin, high + margin)
    panel.plot(ends, ends, color=FAINT_COLOUR, linewidth=1, linestyle="--", zorder=1, label="learned = true")
    panel.set(xlim=ends, ylim=ends, aspect="equal", xlabel="true weight", ylabel="learned weight", title=title)
    panel.legend(loc="upper left", fontsize=9)


def _draw_pearson(panel: Axes, group: GameGroup) -> None:
    rewards = {
        "expert_reward_pearson": ("attacker's reward", "-"),
        "dependent_reward_pearson": ("defender's dependent reward", "--"),
    }
    for label, run in group.runs.items():
        for metric, (whose, line) in rewards.items():
            if (curve := run.curve(metric)) is not None:
                draw_curve(panel, curve, algorithm_style(run.algorithm).colour, f"{label}, {whose}", line, band=0.15)
    panel.axhline(1.0, color=FAINT_COLOUR, linewidth=1, linestyle=":")
    panel.set(ylabel="Pearson correlation with the truth", title="Agreement with the truth (1: perfect)")
    number_iterations(panel)
    if panel.get_legend_handles_labels()[0]:
        panel.legend(loc="lower right", fontsize=9)
