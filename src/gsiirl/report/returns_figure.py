"""Returns of both sides along the iterations (the paper's Figures 2, 3 a and b, and 4)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gsiirl.report.figure_style import FAINT_COLOUR
from gsiirl.report.group import GameGroup
from gsiirl.report.learning_curves import (
    draw_curves,
    draw_level,
    legend_columns,
    legend_handles,
    marl_levels,
    number_iterations,
    random_level,
    tell_random_play,
)

ROWS = (
    ("deployed", "deployed: what the {learner} learned, against the real {expert}"),
    ("model", "model: both play what the {learner} {expects}"),
)


def draw_returns(group: GameGroup) -> Figure | None:
    """Mean and a band of one standard deviation over seeds, deployed above model; None without any curve."""
    rows = [row for row in ROWS if any(_curves(group, row[0], side) for side in ("learner", "expert"))]
    if not rows:
        return None
    figure = Figure(figsize=(9.6, 0.75 + 3.0 * len(rows)), layout="constrained")
    axes = figure.subplots(len(rows), 2, squeeze=False, sharex=True, sharey="col")
    learner, expert = group.sides
    words = {"learner": learner, "expert": expert, "expects": learner.verb("expects", "expect")}
    spans = {side: _span(group, [kind for kind, _ in rows], side) for side in ("learner", "expert")}
    for (kind, meaning), (left, right) in zip(rows, axes, strict=True):
        for panel, side, name in ((left, "learner", learner), (right, "expert", expert)):
            _draw_panel(panel, group, kind, side, spans[side])
            panel.set_title(f"{name.possessive.capitalize()} return", pad=20)
            told = panel.annotate(
                meaning.format(**words),
                (0, 1),
                xytext=(0, 6),
                xycoords="axes fraction",
                textcoords="offset points",
                color=FAINT_COLOUR,
                size=9,
            )
            # Words that are longer than the panel is wide would else make it narrower.
            told.set_in_layout(False)
    for panel in axes[-1]:
        number_iterations(panel)
    levels = marl_levels(group, "return_learner")
    random = random_level(group, "return_learner")
    handles = legend_handles(group, levels if random is None else [*levels, random])
    figure.legend(handles=handles, loc="outside upper center", ncols=legend_columns(handles), fontsize=9.5)
    return figure


def _curves(group: GameGroup, kind: str, side: str) -> bool:
    return any(run.curve(f"{kind}_return_{side}") for run in group.learners.values())


def _span(group: GameGroup, kinds: list[str], side: str) -> tuple[float, float] | None:
    """The returns that a side's panels have to show, if there are any.

    That is where runs begin, where they mostly are, where they end, and all levels. A run that loses its way for a
    while would else flatten everything that the figure is for.
    """
    heights = [level.value for level in marl_levels(group, f"return_{side}")]
    for run in group.learners.values():
        for curve in (run.curve(f"{kind}_return_{side}") for kind in kinds):
            if curve is not None:
                mean, std = curve.mean, float(curve.std[-1])
                heights += [float(mean[0]), float(np.median(mean)), float(mean[-1]) - std, float(mean[-1]) + std]
    if not heights:
        return None
    low, high = min(heights), max(heights)
    random = random_level(group, f"return_{side}")
    if random is not None and low - (high - low) <= random.value <= high + (high - low):
        low, high = min(low, random.value), max(high, random.value)
    return low, high


def _draw_panel(panel: Axes, group: GameGroup, kind: str, side: str, span: tuple[float, float] | None) -> None:
    draw_curves(panel, group, f"{kind}_return_{side}")
    for level in marl_levels(group, f"return_{side}"):
        draw_level(panel, level)
    if span is None:
        return
    low, high = span
    margin = 0.08 * (high - low) or 1.0
    panel.set_ylim(low - margin, high + margin)
    random = random_level(group, f"return_{side}")
    if random is None:
        return
    if low <= random.value <= high:
        draw_level(panel, random)
    else:
        tell_random_play(panel, random, below=random.value < low)
