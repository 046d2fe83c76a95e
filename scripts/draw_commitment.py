"""Draw what every commitment of the textbook game earns, and mark the ones that were learned (docs/commitment.md).

Usage: python scripts/draw_commitment.py [--output docs/figures/textbook-commitment.png]

Takes a minute, most of it for compiling.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gsiirl import GSIIRL, Problem, RespondingExpert
from gsiirl.games import TabularGame
from gsiirl.report.figures.page_figure import figure_files
from gsiirl.report.figures.style import FAINT_COLOUR, TEXT_COLOUR, figure_style

LEARNER = np.array([[2.0, 4.0], [1.0, 3.0]])
EXPERT = np.eye(2)
COLOURS = {0.3: "#0f766e", 0.1: "#2563eb", 0.02: "#b45309"}
"""By temperature."""


def earned(first: np.ndarray, temperature: float) -> np.ndarray:
    """The learner's return when its first action has the probability `first`, in closed form."""
    left = 1.0 / (1.0 + np.exp((1.0 - 2.0 * first) / temperature))
    mixed, answer = np.stack([first, 1.0 - first], -1), np.stack([left, 1.0 - left], -1)
    return np.einsum("na,nb,ab->n", mixed, answer, LEARNER)


def learned(temperature: float) -> float:
    """The probability of the first action in the commitment that is learned from the expert's choices."""
    game = TabularGame.from_arrays(np.ones((1, 2, 2, 1)), initial=[1.0], horizon=1)
    problem = Problem(game, dependent_value=LEARNER[None], discount=1.0, temperature=temperature)
    expert = RespondingExpert(game, EXPERT[None], temperature=temperature, discount=1.0)
    return float(GSIIRL(problem).fit(expert, iterations=30, trajectories=100, seed=0).policy[0, 0, 0])


def draw(marks: dict[float, float]) -> Figure:
    """One curve a temperature, with the learned commitment on it."""
    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    axes = figure.subplots()
    first = np.linspace(0.0, 1.0, 2001)
    for temperature, mark in marks.items():
        colour = COLOURS[temperature]
        height = earned(np.array([mark]), temperature)[0]
        axes.plot(first, earned(first, temperature), color=colour, linewidth=1.8, label=f"τ = {temperature}")
        axes.plot(mark, height, "o", color=colour, markersize=8, markeredgecolor="white")
        axes.annotate(
            f"{height:.2f}",
            (mark, height),
            (0, -16),
            textcoords="offset points",
            ha="center",
            color=colour,
            fontsize=9.5,
        )
    axes.axhline(2.0, color=FAINT_COLOUR, linestyle="--", linewidth=1.2)
    axes.text(0.01, 2.04, "every equilibrium, as τ → 0", color=FAINT_COLOUR, fontsize=9.5)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(1.4, 3.6)
    axes.set_xlabel("probability of the learner's first action", color=TEXT_COLOUR)
    axes.set_ylabel("learner's return", color=TEXT_COLOUR)
    axes.set_title("What a commitment earns; dots: learned")
    axes.legend(loc="upper right")
    return figure


def main() -> None:
    """Learn, draw and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("docs/figures/textbook-commitment.png"))
    arguments = parser.parse_args()
    marks = {temperature: learned(temperature) for temperature in COLOURS}
    with figure_style():
        arguments.output.write_bytes(figure_files(draw(marks))["png"])


if __name__ == "__main__":
    main()
