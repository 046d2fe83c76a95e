"""Record logit equilibria of random bimatrix games as solved by pygambit, for the tests.

Usage: python scripts/record_pygambit.py [--output tests/data/pygambit_logit.npz]

Needs numpy and pygambit 16, which this project does not depend on (there may be no wheel: its source package builds
with a C++ compiler in a few minutes). Recorded with pygambit 16.7.0 on Python 3.11; 16.5.0 gives the same numbers to
the last bit. Nothing is polished: policies are pygambit's own, and `reached` is the lambda at which pygambit stopped,
within 1e-10 of the one asked for. A run takes two minutes of processor time, most of it for the traces.

Entries of the file (float64 unless said; payoffs are [game, a_l, a_e], p learner, q expert, lambda = 1/tau):

learner_payoff, expert_payoff [20, 10, 10]   numpy default_rng(0).random, first all of the learner's, then the expert's
rationality [3]                              the lambda asked for; no branch folds before the last of them
learner, expert [20, 3, 10]                  p and q
reached [20, 3]                              the lambda at which pygambit stopped
residual [20, 3]                             max |ln pi - log_softmax(lambda E payoff)| at the lambda asked for
residual_reached [20, 3]                     the same at the lambda reached
folding_game [3] int                         games whose branch folds later
folding_rationality [2]                      the lambda asked for
folding_learner, folding_expert [3, 2, 10]   and folding_reached, folding_residual, folding_residual_reached [3, 2]
folding_turns [3, 4]                         lambda where the branch turns round before the last lambda asked for, in
                                             order, nan-padded: extremes of traced points, so right to about 1e-5
trace_rationality [n]                        lambda along the branch of the last folding game, thinned,
trace_learner, trace_expert [n, 10]          and the policies there
versions [3] str                             pygambit, Python, numpy
"""

import argparse
import platform
from pathlib import Path

import numpy as np
import pygambit  # pyright: ignore[reportMissingImports]
from numpy.typing import NDArray
from pygambit.qre import logit_solve_branch, logit_solve_lambda  # pyright: ignore[reportMissingImports]

Array = NDArray[np.float64]

GAMES, ACTIONS = 20, 10
RATIONALITY = (1.0, 5.0, 10.0)
FOLDING_GAMES = (5, 7, 9)
FOLDING_RATIONALITY = (20.0, 40.0)
TOLERANCE = 1e-9


def log_softmax(values: Array) -> Array:
    shifted = values - values.max()
    return shifted - np.log(np.exp(shifted).sum())


def residual(learner_payoff: Array, expert_payoff: Array, learner: Array, expert: Array, rationality: float) -> float:
    return float(
        max(
            np.abs(np.log(learner) - log_softmax(rationality * learner_payoff @ expert)).max(),
            np.abs(np.log(expert) - log_softmax(rationality * expert_payoff.T @ learner)).max(),
        )
    )


def profile(point) -> tuple[Array, Array]:
    learner, expert = (
        np.array([float(point.profile[strategy]) for strategy in player.strategies])
        for player in point.profile.game.players
    )
    return learner, expert


def solve(learner_payoff: Array, expert_payoff: Array, rationality: float) -> tuple[Array, Array, float]:
    """Return p, q and the lambda reached; pygambit stops at its own tolerance in lambda, so try some step sizes."""
    game = pygambit.Game.from_arrays(learner_payoff, expert_payoff)
    candidates = []
    for first_step in (0.03, 0.02, 0.01):
        for largest_acceleration in (1.1, 1.0):
            branch = logit_solve_lambda(game, lam=[rationality], first_step=first_step, max_accel=largest_acceleration)
            point = branch[-1]
            learner, expert = profile(point)
            error = residual(learner_payoff, expert_payoff, learner, expert, rationality)
            candidates.append((error, learner, expert, float(point.lam)))
    error, learner, expert, reached = min(candidates, key=lambda candidate: candidate[0])
    if error > TOLERANCE:
        raise RuntimeError(f"residual {error:.1e} at lambda = {rationality}")
    return learner, expert, reached


def record_group(learner_payoff: Array, expert_payoff: Array, rationality: tuple[float, ...]) -> dict[str, Array]:
    shape = (len(learner_payoff), len(rationality))
    learner, expert = np.zeros((*shape, ACTIONS)), np.zeros((*shape, ACTIONS))
    reached, error, error_reached = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for game, target in np.ndindex(shape):
        payoffs = learner_payoff[game], expert_payoff[game]
        p, q, stopped = solve(*payoffs, rationality[target])
        learner[game, target], expert[game, target], reached[game, target] = p, q, stopped
        error[game, target] = residual(*payoffs, p, q, rationality[target])
        error_reached[game, target] = residual(*payoffs, p, q, stopped)
    return {
        "learner": learner,
        "expert": expert,
        "reached": reached,
        "residual": error,
        "residual_reached": error_reached,
    }


def trace(learner_payoff: Array, expert_payoff: Array, last: float) -> tuple[Array, Array, Array, Array]:
    """Return lambda, p and q along the branch, thinned, up to the first point beyond `last`, and the turning points."""
    game = pygambit.Game.from_arrays(learner_payoff, expert_payoff)
    points = logit_solve_branch(game, maxregret=1e-3, first_step=0.01, max_accel=1.0)
    rationality = np.array([float(point.lam) for point in points])
    stop = int(np.argmax(rationality > last))
    if stop == 0:
        raise RuntimeError(f"the branch did not reach lambda = {last}")
    rationality = rationality[: stop + 1]
    direction = np.sign(np.diff(rationality))
    turns = rationality[1:-1][direction[1:] != direction[:-1]]
    kept = np.unique(np.linspace(0, stop, 200).astype(int))
    pairs = [profile(points[index]) for index in kept]
    learner, expert = np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])
    return rationality[kept], learner, expert, turns


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--output", type=Path, default=Path("tests/data/pygambit_logit.npz"))
    output: Path = parser.parse_args().output

    random = np.random.default_rng(0)
    learner_payoff = random.random((GAMES, ACTIONS, ACTIONS))
    expert_payoff = random.random((GAMES, ACTIONS, ACTIONS))
    chosen = list(FOLDING_GAMES)
    record = record_group(learner_payoff, expert_payoff, RATIONALITY)
    folding = record_group(learner_payoff[chosen], expert_payoff[chosen], FOLDING_RATIONALITY)

    folding_turns = np.full((len(chosen), 4), np.nan)
    traced = None
    for row, game in enumerate(chosen):
        traced = trace(learner_payoff[game], expert_payoff[game], FOLDING_RATIONALITY[-1])
        folding_turns[row, : len(traced[3])] = traced[3]
    assert traced is not None

    entries = {
        "learner_payoff": learner_payoff,
        "expert_payoff": expert_payoff,
        "rationality": np.array(RATIONALITY),
        **record,
        "folding_game": np.array(chosen),
        "folding_rationality": np.array(FOLDING_RATIONALITY),
        **{f"folding_{name}": values for name, values in folding.items()},
        "folding_turns": folding_turns,
        "trace_rationality": traced[0],
        "trace_learner": traced[1],
        "trace_expert": traced[2],
        "versions": np.array([str(pygambit.__version__), platform.python_version(), np.__version__]),
    }
    np.savez_compressed(output, allow_pickle=False, **entries)
    for name, group in (("plain", record), ("folding", folding)):
        asked, reached = group["residual"].max(), group["residual_reached"].max()
        print(f"{name} games: largest residual {asked:.1e}, at the lambda reached {reached:.1e}")
    print(f"turning points {folding_turns.tolist()}; {len(traced[0])} points of the trace")


if __name__ == "__main__":
    main()
