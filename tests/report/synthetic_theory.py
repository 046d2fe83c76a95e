"""Made-up findings, shaped like real ones, for the tests of the theory's page."""

import numpy as np

from gsiirl.runs import Curve, Finding, Findings, Measurement, Panel


def curve(name: str, x: np.ndarray, y: np.ndarray, role: str = "ours", spread: float = 0.0) -> Curve:
    return Curve(name, x.tolist(), y.tolist(), (spread * y).tolist() if spread else [], role)


def power_law() -> Finding:
    """Two panels on logarithmic axes, all three roles, a band."""
    step, budget = np.logspace(-6, -1, 11), 2.0 ** np.arange(3, 10)
    return Finding(
        key="lemma-2",
        title="Hypergradient by finite differences",
        claim="The bias of the two-sided estimate falls with the square of the step, & its variance with 1/N.",
        printed="A bias that falls with the step itself.",
        reading="On logarithmic axes a power law is a straight line; its slope is the exponent.",
        measurements=[
            Measurement("slope of the bias over the step", 1.9996, at_least=1.8, at_most=2.2),
            Measurement("largest relative error at the smallest step", 3.17e-9, at_most=1e-6),
            Measurement("time of one estimate", 0.0123, unit="s"),
        ],
        panels=[
            Panel(
                "Bias of the estimate",
                "step p",
                "relative error",
                [
                    curve("two-sided differences, response measured at both ends", step, step**2, spread=0.4),
                    curve("as printed: demonstrations held fixed", step, 31 + 0 * step, "paper"),
                    curve("slope 2", step, 0.1 * step**2, "guide"),
                ],
            ),
            Panel(
                "Spread over draws",
                "draws N",
                "standard deviation",
                [
                    curve("mean of N draws", budget, 3 / np.sqrt(budget), spread=0.2),
                    curve("as printed", budget, 2.5 + 0 * budget, "paper"),
                    curve("slope -1/2", budget, 4 / np.sqrt(budget), "guide"),
                ],
            ),
        ],
        seconds=3.21,
        check="Lemma 2",
    )


def missed() -> Finding:
    """One panel on linear axes, and a bound that is missed by less than the shown digits."""
    iteration = np.arange(50.0)
    return Finding(
        key="theorem-1",
        title="The leader's loop converges",
        claim="The distance to the stationary point falls at every iteration.",
        printed="",
        reading="The curve must never rise.",
        measurements=[Measurement("largest ratio of two distances", 1.00001, at_most=1.0)],
        panels=[
            Panel(
                "Distance to the stationary point",
                "iteration",
                "distance",
                [
                    curve("our step size", iteration, np.exp(-iteration / 10), spread=0.3),
                    curve("the paper's step size", iteration, 1 - 0.004 * iteration, "paper"),
                ],
                log_x=False,
                log_y=False,
            )
        ],
        seconds=12.0,
        check="Theorem 1",
    )


def many_panels() -> Finding:
    """Three panels, many curves, points that cannot be drawn, and a number that is none."""
    size = np.array([4.0, 16.0, 64.0, 256.0])
    zero = np.array([1e-15, 0.0, 2e-16, np.nan])
    return Finding(
        key="corollary-2-1",
        title="What the end costs",
        claim="The error at the end is the sum of three terms.",
        printed="Two terms.",
        reading="Each panel varies one term.",
        measurements=[Measurement("number of games", 12.0), Measurement("a ratio", float("nan"), at_most=2.0)],
        panels=[
            Panel(
                f"Term {term}",
                f"quantity {term}",
                "error",
                [curve(f"game {game}", size, (1 + game) / size**term) for game in range(4)]
                + [curve("at the floor of the arithmetic", size, zero)],
            )
            for term in (1, 2, 3)
        ],
        seconds=0.4,
        check="Corollary 2.1",
    )


def all_findings() -> Findings:
    return Findings(True, [power_law(), missed(), many_panels()], {"gsiirl": "0.0", "jax": "0.0"}, ["Lemma 6"])
