"""One metric of every run along the iterations, with MARL's level and random play's."""

from dataclasses import dataclass
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from gsiirl.report.algorithm import algorithm_style
from gsiirl.report.figure_style import FAINT_COLOUR
from gsiirl.report.group import GameGroup

RANDOM_COLOUR = "#94a3b8"
BAND_ALPHA = 0.18


@dataclass(frozen=True)
class Level:
    """A horizontal line: what somebody comes to who learns nothing along the iterations."""

    label: str
    value: float
    colour: str
    line: Literal["--", "-.", ":"]


def draw_curves(panel: Axes, group: GameGroup, metric: str) -> list[float]:
    """Mean and a band of one standard deviation over seeds, one curve a run that learns; the heights they reach."""
    heights: list[float] = []
    for label, run in group.learners.items():
        curve = run.curve(metric)
        if curve is None:
            continue
        colour = algorithm_style(run.algorithm).colour
        low, high = curve.mean - curve.std, curve.mean + curve.std
        panel.fill_between(curve.iteration, low, high, color=colour, alpha=BAND_ALPHA, linewidth=0)
        # A run of no iterations is one point, which no line would show.
        marker = "o" if len(curve.iteration) == 1 else ""
        panel.plot(curve.iteration, curve.mean, color=colour, linewidth=2, marker=marker, label=label)
        heights += [float(low.min()), float(high.max())]
    return heights


def draw_level(panel: Axes, level: Level) -> None:
    """One horizontal line."""
    panel.axhline(level.value, color=level.colour, linewidth=1.6, linestyle=level.line)


def marl_levels(group: GameGroup, metric: str) -> list[Level]:
    """MARL's level of a metric of the deployed pair, given as `return_learner`, `collision_rate` and the like."""
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
    """Random play's level of a metric, or None where it is not known."""
    value = group.reference(f"random_{metric}")
    return None if value is None else Level(f"learner that {group.words.reference[0]}", value, RANDOM_COLOUR, ":")


def legend_handles(group: GameGroup, levels: list[Level]) -> list[Line2D]:
    """An entry for every run that learns, then one for every level."""
    curves = [
        Line2D([], [], color=algorithm_style(run.algorithm).colour, linewidth=2, label=label)
        for label, run in group.learners.items()
        if run.kept_seeds
    ]
    return curves + [
        Line2D([], [], color=level.colour, linewidth=1.6, linestyle=level.line, label=level.label) for level in levels
    ]


def legend_columns(handles: list[Line2D]) -> int:
    """So that a legend above a figure fills its rows."""
    return 4 if len(handles) <= 4 else 3


def number_iterations(panel: Axes) -> None:
    """The horizontal axis of a panel along the iterations."""
    panel.set_xlabel("iteration")
    panel.margins(x=0.02)
    panel.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def tell_random_play(panel: Axes, random: Level, below: bool) -> None:
    """In words, where a line drawn to scale would flatten everything else."""
    panel.annotate(
        f"{random.label}: {random.value:.2f} {'↓' if below else '↑'}",
        (0.98, 0.04 if below else 0.9),
        xycoords="axes fraction",
        ha="right",
        color=FAINT_COLOUR,
        size=9,
    )
