"""Panels of one metric over iterations, with horizontal lines for MARL and random play."""

from dataclasses import dataclass
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, PercentFormatter

from gsiirl.report.figures.style import FAINT_COLOUR
from gsiirl.report.read.group import GameGroup
from gsiirl.report.read.run import MetricCurve
from gsiirl.report.words.algorithms import algorithm_style
from gsiirl.report.words.numbers import format_number

RANDOM_COLOUR = "#94a3b8"


@dataclass(frozen=True)
class Level:
    """A horizontal line: a final value that is no curve of its own, such as MARL's."""

    label: str
    value: float
    colour: str
    line: Literal["--", "-.", ":"]


@dataclass(frozen=True)
class CurvePanel:
    """A panel of one metric over iterations: what a drawing of it shows, and what the chart of a page shows."""

    metric: str
    title: str
    meaning: str
    """What the metric is, in a line under the title; may be empty."""
    levels: list[Level]
    limits: tuple[float, float] | None
    """Ends of the vertical axis; None where there is nothing to show."""
    far: Level | None = None
    """A level so far off that a line would flatten the curves: it is told in words."""
    shares: bool = False
    """Whether values are shares, shown as percentages."""


def draw_panel(axes: Axes, group: GameGroup, panel: CurvePanel) -> None:
    """The curves and levels of a panel."""
    draw_curves(axes, group, panel.metric)
    for level in panel.levels:
        draw_level(axes, level)
    if panel.limits is not None:
        axes.set_ylim(*panel.limits)
        if panel.far is not None:
            tell_random_play(axes, panel.far, below=panel.far.value < panel.limits[0])
    if panel.shares:
        axes.yaxis.set_major_formatter(PercentFormatter(1.0))


def draw_curve(panel: Axes, curve: MetricCurve, colour: str, label: str, line: str = "-", band: float = 0.18) -> None:
    """The mean over seeds as a line, and a band of one standard deviation of opacity `band`."""
    panel.fill_between(
        curve.iteration, curve.mean - curve.std, curve.mean + curve.std, color=colour, alpha=band, linewidth=0
    )
    # A run of no iterations is one point, which no line would show.
    marker = "o" if len(curve.iteration) == 1 else ""
    panel.plot(curve.iteration, curve.mean, line, color=colour, linewidth=2, marker=marker, label=label)


def draw_curves(panel: Axes, group: GameGroup, metric: str) -> None:
    """One curve for each run that learns."""
    for label, run in group.learners.items():
        if (curve := run.curve(metric)) is not None:
            draw_curve(panel, curve, algorithm_style(run.algorithm).colour, label)


def draw_level(panel: Axes, level: Level) -> None:
    """One horizontal line."""
    panel.axhline(level.value, color=level.colour, linewidth=1.6, linestyle=level.line)


def marl_levels(group: GameGroup, metric: str) -> list[Level]:
    """MARL's levels, one for each solver, of a metric of the deployed pair (`return_learner`, `collision_rate`)."""
    levels: list[Level] = []
    truth = group.reference(f"truth_{metric}")
    if truth is not None:
        levels.append(Level("MARL, given both true rewards", truth, algorithm_style("marl").colour, "--"))
    for label, run in group.runs.items():
        estimate = run.estimate(f"deployed_{metric}") or run.estimate(metric)
        if run.algorithm == "marl-maddpg" and estimate is not None:
            levels.append(Level(label, estimate.mean, algorithm_style(run.algorithm).colour, "-."))
    return levels


def random_level(group: GameGroup, metric: str) -> Level | None:
    """The level of random play, or None where no run holds it."""
    value = group.reference(f"random_{metric}")
    return None if value is None else Level(f"learner that {group.words.reference[0]}", value, RANDOM_COLOUR, ":")


def draw_legend(figure: Figure, group: GameGroup, levels: list[Level]) -> None:
    """A legend above the figure: an entry for each run that learns, then one for each level."""
    handles = [
        Line2D([], [], color=algorithm_style(run.algorithm).colour, linewidth=2, label=label)
        for label, run in group.learners.items()
        if run.kept_seeds
    ]
    handles += [
        Line2D([], [], color=each.colour, linewidth=1.6, linestyle=each.line, label=each.label) for each in levels
    ]
    # So many columns that the rows are full.
    figure.legend(handles=handles, loc="outside upper center", ncols=4 if len(handles) <= 4 else 3, fontsize=9.5)


def number_iterations(panel: Axes) -> None:
    """Make the horizontal axis one of whole iterations."""
    panel.set_xlabel("iteration")
    panel.margins(x=0.02)
    panel.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def tell_random_play(panel: Axes, random: Level, below: bool) -> None:
    """Write the level of random play as text, where it lies so far off that a line would flatten the curves."""
    place = (0.98, 0.04 if below else 0.9)
    panel.annotate(far_in_words(random, below), place, xycoords="axes fraction", ha="right", color=FAINT_COLOUR, size=9)


def far_in_words(random: Level, below: bool) -> str:
    """The level of random play, with an arrow to where it lies."""
    return f"{random.label}: {format_number(random.value)} {'↓' if below else '↑'}"
