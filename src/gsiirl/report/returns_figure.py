"""Returns of both sides along the iterations (the paper's Figure 4, middle and right)."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.figure_style import FAINT_COLOUR
from gsiirl.report.group import GameGroup

ROWS = (
    ("deployed", "deployed: the {learner} that learned against the real {expert}"),
    ("model", "model: both play what the {learner} expects"),
)
RANDOM_COLOUR = "#94a3b8"
BAND_ALPHA = 0.18


def draw_returns(group: GameGroup) -> Figure | None:
    """Mean and a band of one standard deviation over seeds, deployed above model; None without any curve."""
    rows = [row for row in ROWS if any(_curves(group, row[0], side) for side in ("learner", "expert"))]
    if not rows:
        return None
    figure = Figure(figsize=(9.6, 0.75 + 3.0 * len(rows)), layout="constrained")
    axes = figure.subplots(len(rows), 2, squeeze=False, sharex=True, sharey="col")
    learner, expert = group.sides
    for (kind, meaning), (left, right) in zip(rows, axes, strict=True):
        for panel, side, name in ((left, "learner", learner), (right, "expert", expert)):
            _draw_panel(panel, group, kind, side)
            panel.set_title(f"{name.capitalize()}'s return", pad=20)
            panel.annotate(
                meaning.format(learner=learner, expert=expert),
                (0, 1),
                xytext=(0, 6),
                xycoords="axes fraction",
                textcoords="offset points",
                color=FAINT_COLOUR,
                size=9,
            )
    for panel in axes[-1]:
        panel.set_xlabel("iteration")
        panel.margins(x=0.02)
        panel.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    figure.legend(handles=_legend(group), loc="outside upper center", ncols=4, fontsize=9.5)
    return figure


def _curves(group: GameGroup, kind: str, side: str) -> bool:
    return any(run.curve(f"{kind}_return_{side}") for run in group.runs.values() if run.algorithm != "marl")


def _draw_panel(panel: Axes, group: GameGroup, kind: str, side: str) -> None:
    edges: list[float] = []
    for label, run in group.runs.items():
        curve = run.curve(f"{kind}_return_{side}") if run.algorithm != "marl" else None
        if curve is None:
            continue
        colour = algorithm_style(run.algorithm).colour
        low, high = curve.mean - curve.std, curve.mean + curve.std
        panel.fill_between(curve.iteration, low, high, color=colour, alpha=BAND_ALPHA, linewidth=0)
        # A run of no iterations is one point, which no line would show.
        marker = "o" if len(curve.iteration) == 1 else ""
        panel.plot(curve.iteration, curve.mean, color=colour, linewidth=2, marker=marker, label=label)
        edges += [float(low.min()), float(high.max())]
    marl, random = reference(group, "truth", side), reference(group, "random", side)
    if marl is not None:
        panel.axhline(marl, color=algorithm_style("marl").colour, linewidth=1.6, linestyle="--")
        edges.append(marl)
    if random is None or not edges:
        return
    low, high = min(edges), max(edges)
    if low - (high - low) <= random <= high + (high - low):
        panel.axhline(random, color=RANDOM_COLOUR, linewidth=1.6, linestyle=":")
        return
    # Drawn to scale it would flatten everything else.
    below = random < low
    panel.annotate(
        f"random play: {random:.2f} {'↓' if below else '↑'}",
        (0.98, 0.04 if below else 0.9),
        xycoords="axes fraction",
        ha="right",
        color=FAINT_COLOUR,
        size=9,
    )


def reference(group: GameGroup, kind: str, side: str) -> float | None:
    """The return of `truth` (MARL with both true rewards) or `random` play, from the first run that holds it."""
    for run in group.runs.values():
        estimate = run.estimate(f"{kind}_return_{side}")
        if estimate is not None:
            return estimate.mean
    return None


def _legend(group: GameGroup) -> list[Line2D]:
    handles = [
        Line2D([], [], color=algorithm_style(run.algorithm).colour, linewidth=2, label=label)
        for label, run in group.runs.items()
        if run.algorithm != "marl" and run.kept_seeds
    ]
    if reference(group, "truth", "learner") is not None:
        colour = algorithm_style("marl").colour
        text = "MARL, given both true rewards"
        handles.append(Line2D([], [], color=colour, linewidth=1.6, linestyle="--", label=text))
    if reference(group, "random", "learner") is not None:
        handles.append(
            Line2D([], [], color=RANDOM_COLOUR, linewidth=1.6, linestyle=":", label="learner plays at random")
        )
    return handles
