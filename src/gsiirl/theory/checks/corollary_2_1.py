"""Corollary 2.1: how far the expert's fitted policy stays from the true one along a run of Algorithm 1.

The feature gap ‖μ_e(π_θe) − μ̂_e‖ ends at a floor, not at 0: at a minimiser of L inside the unit ball

    ∇L = (μ_e(π_θe) − μ̂_e)/τ + λθ_e* = 0,     so that     ‖μ_e(π_θe) − μ̂_e‖ = τλ‖θ_e*‖.

The difference of returns is below the gap: for linear r_e and ‖θ‖ ≤ 1, |θ·(μ_e(π_θe) − μ_e(π_e))| ≤ the gap. Policies
are π_θe = (π_l, respond(π_l, θ_e)) and π_e = (π_l, respond(π_l, true r_e)) with the π_l played in that iteration.
"""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from gsiirl.irl.maximum_likelihood import MaximumLikelihood, constant_steps
from gsiirl.runs.findings import Finding, Measurement, Panel
from gsiirl.theory.support.algorithm_1 import Games, algorithm_1, draw_games
from gsiirl.theory.support.curves import curve, fitted_slope, median
from gsiirl.theory.support.games import TEMPERATURE, RandomProblem
from gsiirl.theory.support.total_derivative import equilibria, lower_gradient, minimisers

REGULARISATIONS = (1e-1, 1e-2, 1e-3)
LAST_STEPS = 10_000
"""Inner steps after the last iteration, with the policy held, before the gap is compared with its floor."""
NEAR_FLOOR = 2.0
"""The rate is read off while the gap is above this many floors."""


@dataclass(frozen=True)
class Gaps:
    """Along a run of K iterations, for N games: how far the fitted expert is from the demonstrated one.

    `gaps` are ‖μ_e(π_θe) − μ̂_e‖, `differences` the larger of |J_e(π_θe) − J_e(π_e)| under θ_e(k + 1) and under the true
    r_e. `floors` are τλ‖θ_e*‖ at the last policy; `settled`, `exact` the gaps there after `LAST_STEPS` more inner steps
    and at θ_e*.
    """

    gaps: Float[np.ndarray, "K N"]
    differences: Float[np.ndarray, "K N"]
    floors: Float[np.ndarray, " N"]
    settled: Float[np.ndarray, " N"]
    exact: Float[np.ndarray, " N"]


@jax.jit
@jax.vmap
def feature_differences(
    problem: RandomProblem, learner_policy: Float[Array, "T S A_l"], at: Float[Array, " m"]
) -> Float[Array, " m"]:
    """μ_e(π_l, respond(π_l, θ_e)) − μ̂_e = τ∇L without λ, in each of N games."""
    return TEMPERATURE * lower_gradient(problem, learner_policy, at, 0.0)


@jax.jit
def settled_estimates(
    problems: RandomProblem,
    policies: Float[Array, "N T S A_l"],
    starts: Float[Array, "N m"],
    regularisation: Float[Array, ""],
    rates: Float[Array, " N"],
) -> Float[Array, "N m"]:
    """θ_e after `LAST_STEPS` inner steps of size `rates` = 1/L_L against policies that are held."""

    def of_one(problem: RandomProblem, policy: Array, start: Array, rate: Array) -> Array:
        loop = MaximumLikelihood(TEMPERATURE, constant_steps(LAST_STEPS), optax.sgd(rate / TEMPERATURE))

        def gradient(theta: Array) -> Array:
            return lower_gradient(problem, policy, theta, regularisation)

        return loop.fit(gradient, start, loop.optimiser.init(start), jnp.asarray(0))[0]

    return jax.vmap(of_one)(problems, policies, starts, rates)


def measure_gaps(games: Games, regularisation: float, iterations: int) -> Gaps:
    """Run Algorithm 1 with exact demonstrations and a constant step, and follow the gap."""
    problems, true = games.problems, np.asarray(games.problems.true_parameters)
    run = algorithm_1(games, 1.0 / games.upper_smoothness, iterations, regularisation)
    gaps, differences = [], []
    for commitments, believed, fitted in zip(run.commitments, run.estimates[:-1], run.estimates[1:], strict=True):
        played = equilibria(problems, commitments, believed).learner_policy
        features = np.asarray(feature_differences(problems, played, fitted))
        gaps.append(np.linalg.norm(features, axis=1))
        returns = [np.sum(theta * features, axis=1) for theta in (np.asarray(fitted), true)]
        differences.append(np.max(np.abs(returns), axis=0))
    policies = equilibria(problems, run.commitments[-1], run.estimates[-2]).learner_policy
    minimiser = minimisers(problems, policies, regularisation)
    rates = 1.0 / (games.lower_smoothness + regularisation)
    settled = settled_estimates(problems, policies, run.estimates[-1], jnp.asarray(regularisation), rates)
    return Gaps(
        gaps=np.stack(gaps),
        differences=np.stack(differences),
        floors=TEMPERATURE * regularisation * np.linalg.norm(minimiser, axis=1),
        settled=np.linalg.norm(feature_differences(problems, policies, settled), axis=1),
        exact=np.linalg.norm(feature_differences(problems, policies, minimiser), axis=1),
    )


def rates(found: Gaps) -> list[float]:
    """The log-log slope of each game's gap against k + 1, up to where it first comes near its floor."""
    slopes = []
    for gaps, floor in zip(found.gaps.T, found.floors, strict=True):
        near = np.flatnonzero(gaps <= NEAR_FLOOR * floor)
        until = int(near[0]) if near.size else len(gaps)
        # Two points and more make a slope; a game that begins at its floor has none.
        if until >= 2:
            slopes.append(fitted_slope(range(1, until + 1), gaps[:until]))
    return slopes


def check(quick: bool) -> Finding:
    """Corollary 2.1 on the games of Theorem 2, for several λ."""
    games = draw_games()
    iterations = 100 if quick else 1600
    found = {regularisation: measure_gaps(games, regularisation, iterations) for regularisation in REGULARISATIONS}
    number = len(games.upper_smoothness)
    measurements, curves = [], []
    steps, ends = range(1, iterations + 1), (1, iterations)
    for regularisation, each in found.items():
        ratios = each.settled / each.floors
        measurements += [
            Measurement(
                f"λ = {regularisation:g}: gap at its end over the floor τλ‖θ_e*‖, smallest of {number} games",
                float(ratios.min()),
                at_least=0.99,
            ),
            Measurement(
                f"λ = {regularisation:g}: gap at its end over the floor τλ‖θ_e*‖, largest",
                float(ratios.max()),
                at_most=1.01,
            ),
            Measurement(
                f"λ = {regularisation:g}: gap after {iterations} iterations over the floor, mean over the games",
                float(np.mean(each.gaps[-1] / each.floors)),
            ),
        ]
        floor = float(each.floors.mean())
        curves += [
            curve(f"gap, λ = {regularisation:g}", steps, each.gaps.mean(axis=1)),
            curve(f"floor τλ‖θ_e*‖, λ = {regularisation:g}", ends, (floor, floor), "guide"),
        ]
    start = float(found[REGULARISATIONS[-1]].gaps[0].mean())
    curves.append(curve("slope -1/4", ends, (start, start * iterations**-0.25), "paper"))
    slopes = [value for each in found.values() for value in rates(each)]
    measurements += [
        Measurement(
            "gap at the exact minimiser θ_e* against the floor: largest relative difference",
            float(max(np.max(np.abs(each.exact / each.floors - 1.0)) for each in found.values())),
            at_most=1e-6,
        ),
        Measurement(
            "difference of returns over the gap, largest of all iterations, games and λ",
            float(max(np.max(each.differences / each.gaps) for each in found.values())),
            at_most=1.0,
        ),
        Measurement(
            f"log-log slope of the gap against the iteration, until it is within {NEAR_FLOOR:g} floors: the slowest "
            f"of {len(slopes)} runs",
            max(slopes),
            at_most=-0.25,
        ),
        Measurement("the same slope, median of the runs", median(slopes)),
    ]
    return Finding(
        key="corollary-2-1",
        title="The expert's return gap falls to a floor set by λ",
        claim=(
            "Along a run of Algorithm 1 the feature gap ‖μ_e(π_θe) - μ̂_e‖ between the fitted and the demonstrated "
            "expert falls at least as fast as k^(-1/4) and ends at τλ‖θ_e*‖; for linear r_e and ‖θ‖ ≤ 1 the "
            "difference of returns |J_e(π_θe) - J_e(π_e)| is never larger than the gap."
        ),
        printed=(
            "The paper lets the difference of returns fall as O(K^(-1/4)) to 0, from Theorem 2. That theorem bounds a "
            "derivative in θ_l and says nothing of the gap; and at a minimiser of L inside the ball the gap is "
            "τλ‖θ_e*‖, which is 0 only for λ = 0 or θ_e* = 0."
        ),
        reading=_reading(found, iterations, number, slopes),
        measurements=measurements,
        panels=[
            Panel(
                "Feature gap of the fitted expert, with its floors",
                "outer iteration k + 1",
                f"feature gap, mean over {number} games",
                curves,
            )
        ],
    )


def _reading(found: dict[float, Gaps], iterations: int, number: int, slopes: list[float]) -> str:
    over = ", ".join(f"{np.mean(each.gaps[-1] / each.floors):.3g} (λ = {key:g})" for key, each in found.items())
    return (
        f"Each curve is the mean gap of {number} random games, at θ_e(k + 1) after the t_k inner steps of iteration k, "
        "with exact demonstrations and the constant step of Theorem 2; horizontal lines are the mean floors. The gap "
        "falls with the number of inner steps, geometrically, and can pass below its floor on the way: the log-log "
        f"slopes of the runs lie between {min(slopes):.2f} and {max(slopes):.2f}. After {iterations} iterations the "
        f"gap is {over} floors; with {LAST_STEPS} more inner steps under the last policy it is the floor."
    )
