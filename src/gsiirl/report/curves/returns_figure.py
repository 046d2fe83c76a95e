"""Returns of both sides over iterations (the paper's Figures 2, 3 a and b, and 4)."""

import numpy as np
from matplotlib.figure import Figure

from gsiirl.report.curves import learning_curves
from gsiirl.report.curves.learning_curves import CurvePanel, Level
from gsiirl.report.figures.style import FAINT_COLOUR
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import MetricCurve
from gsiirl.report.words.experiments import SideName

MEANINGS = {
    "deployed": "deployed: what the {learner} learned, against the real {expert}",
    "model": "model: both play what the {learner} {expects}",
}
"""Of each row of panels."""

Span = tuple[float, float]


def draw_returns(group: GameGroup) -> Figure | None:
    """Mean over seeds and a band of one standard deviation, deployed above model; None where no run has a curve."""
    panels = returns_panels(group)
    if not panels:
        return None
    rows = len(panels) // 2
    figure = Figure(figsize=(9.6, 0.75 + 3.0 * rows), layout="constrained")
    axes = figure.subplots(rows, 2, squeeze=False, sharex=True, sharey="col")
    for each, panel in zip(axes.flat, panels, strict=True):
        learning_curves.draw_panel(each, group, panel)
        each.set_title(panel.title, pad=20)
        offset = {"xytext": (0, 6), "xycoords": "axes fraction", "textcoords": "offset points"}
        told = each.annotate(panel.meaning, (0, 1), color=FAINT_COLOUR, size=9, **offset)
        # Text that is wider than the panel would else make it narrower.
        told.set_in_layout(False)
    for each in axes[-1]:
        learning_curves.number_iterations(each)
    learning_curves.draw_legend(figure, group, returns_levels(group))
    return figure


def returns_panels(group: GameGroup) -> list[CurvePanel]:
    """Learner and expert deployed, then by the model; without a row of which no run has a curve."""
    rows = [kind for kind in MEANINGS if any(_curves(group, kind, side) for side in ("learner", "expert"))]
    learner, expert = group.sides
    expects = learner.verb("expects", "expect")
    spans = {side: _span(group, rows, side) for side in ("learner", "expert")}
    return [
        _panel(group, kind, side, name, MEANINGS[kind].format(learner=learner, expert=expert, expects=expects), span)
        for kind in rows
        for (side, span), name in zip(spans.items(), (learner, expert), strict=True)
    ]


def returns_levels(group: GameGroup) -> list[Level]:
    """The levels of the legend: MARL's and random play's."""
    random = learning_curves.random_level(group, "return_learner")
    return learning_curves.marl_levels(group, "return_learner") + ([] if random is None else [random])


def _curves(group: GameGroup, kind: str, side: str) -> list[MetricCurve]:
    curves = (run.curve(f"{kind}_return_{side}") for run in group.learners.values())
    return [curve for curve in curves if curve is not None]


def _span(group: GameGroup, kinds: list[str], side: str) -> Span | None:
    """The lowest and the highest return that a side's panels must show; None where there are none.

    These are the first, the median and the last mean of every curve, the last also less and plus its standard
    deviation, and all levels. Curves are cut off elsewhere, so that one bad stretch of one run does not flatten all.
    """
    heights = [level.value for level in learning_curves.marl_levels(group, f"return_{side}")]
    for curve in (curve for kind in kinds for curve in _curves(group, kind, side)):
        mean, std = curve.mean, float(curve.std[-1])
        heights += [float(mean[0]), float(np.median(mean)), float(mean[-1]) - std, float(mean[-1]) + std]
    if not heights:
        return None
    low, high = min(heights), max(heights)
    random = learning_curves.random_level(group, f"return_{side}")
    if random is not None and low - (high - low) <= random.value <= high + (high - low):
        low, high = min(low, random.value), max(high, random.value)
    return low, high


def _panel(group: GameGroup, kind: str, side: str, name: SideName, meaning: str, span: Span | None) -> CurvePanel:
    levels, far, limits = learning_curves.marl_levels(group, f"return_{side}"), None, None
    if span is not None:
        low, high = span
        margin = 0.08 * (high - low) or 1.0
        limits = low - margin, high + margin
        random = learning_curves.random_level(group, f"return_{side}")
        if random is not None and low <= random.value <= high:
            levels.append(random)
        else:
            far = random
    title = f"{name.possessive.capitalize()} return"
    return CurvePanel(f"{kind}_return_{side}", title, meaning, levels, limits, far)
