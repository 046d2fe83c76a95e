"""The learned weights of the expert's reward as bars, grouped by feature."""

import numpy as np
from matplotlib.figure import Figure

from gsiirl.report.figures.style import TEXT_COLOUR
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.words.algorithms import algorithm_style

BAR, BETWEEN = 0.2, 0.22
"""Heights of a bar and of the gap between two groups, in inches."""
MOST_FEATURES = 24
"""A reward of more features, such as a network, is not drawn: single weights of it say nothing."""


def draw_weights(group: GameGroup, truth: dict[str, float]) -> Figure | None:
    """Means and standard deviations over seeds of the runs that learned; None without one of so few features.

    Every vector of weights is scaled to length 1: a reward times a positive number describes the same wishes.
    """
    learned = {label: run for label, run in group.learners.items() if 0 < len(_names(run)) <= MOST_FEATURES}
    if not learned:
        return None
    names = _names(next(iter(learned.values())))
    learned = {label: run for label, run in learned.items() if _names(run) == names}
    height = len(learned) * BAR + BETWEEN
    figure = Figure(figsize=(9.6, len(names) * height + 1.1), layout="constrained")
    axes = figure.subplots()
    places = np.arange(len(names)) * height
    for number, (label, run) in enumerate(learned.items()):
        weights = _directions(run)
        std = weights.std(axis=0, ddof=1) if len(weights) > 1 else np.zeros(len(names))
        look = {"color": algorithm_style(run.algorithm).colour, "error_kw": {"elinewidth": 1.2, "ecolor": TEXT_COLOUR}}
        axes.barh(places + number * BAR, weights.mean(axis=0), 0.86 * BAR, xerr=std, label=label, **look)
    middle = places + (len(learned) - 1) * BAR / 2
    known = [index for index, name in enumerate(names) if name in truth]
    if known:
        true = np.array([truth[names[index]] for index in known])
        true = true / (np.linalg.norm(true) or 1.0)
        half = len(learned) * BAR / 2 + 0.04
        axes.vlines(true, middle[known] - half, middle[known] + half, color=TEXT_COLOUR, linewidth=2.4, label="true")
    axes.axvline(0.0, color=TEXT_COLOUR, linewidth=0.8)
    axes.set_yticks(middle, names)
    axes.tick_params(axis="y", labelcolor=TEXT_COLOUR)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("weight (weights of a reward scaled to length 1)")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=4, fontsize=9.5)
    return figure


def _names(run: ReportedRun) -> list[str]:
    """Feature names of the learned weights of the expert's reward; [] where the run has none."""
    if run.learned is None or run.weights("expert_reward") is None:
        return []
    return run.learned.names["expert_reward"]


def _directions(run: ReportedRun) -> np.ndarray:
    """Weights scaled to length 1, [seeds, features]; a seed that learned nothing keeps its zeros."""
    weights = run.weights("expert_reward")
    assert weights is not None
    length = np.linalg.norm(weights, axis=1, keepdims=True)
    return weights / np.where(length > 0, length, 1.0)
