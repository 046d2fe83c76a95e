"""Lemma 2 in full against brute force: d f(θ_l, θ_e*(θ_l)) / dθ_l, inside the unit ball and on its sphere."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.hypergradients import AbstractEstimator, FiniteDifference, HessianVectorCG, Implicit
from gsiirl.learners.bilevel import LowerLevel
from gsiirl.runs.findings import Finding, Measurement, Panel
from gsiirl.theory.support.brute_force import Case, Measured
from gsiirl.theory.support.curves import curve, extremes, fitted_slope, guide, median
from gsiirl.theory.support.games import SIZES, ForwardModel, Size

TOLERANCE = 1e-5
REGULARISATION = 0.1
"""Large enough for θ_e* to move with θ_l inside the ball."""
WEAK_REGULARISATION = 1e-3
"""Small enough not to pull into the ball what lies outside, and for the error of `well_specified` by λ not to show."""
INSIDE, OUTSIDE = 0.5, 1.6
"""‖θ_true‖ where the ball is not to bind, and where it is."""
IMPLICIT = Implicit("measured")
ESTIMATORS: dict[str, AbstractEstimator] = {
    "Implicit": IMPLICIT,
    "HessianVectorCG": HessianVectorCG("measured"),
    "FiniteDifference": FiniteDifference("measured"),
}
UNSYMMETRIC = ("Implicit", "FiniteDifference")
"""The estimators that do not need H to be symmetric."""
RESPONSES = {"well_specified": "ours", "measured": "ours", "demonstrations held fixed (the paper)": "paper"}
"""Responses, and the roles of their curves."""
MODELS: dict[ForwardModel, str] = {"logit": "logit equilibrium", "soft_joint": "eq. 5-7"}


def errors_of_responses(cases: Sequence[Sequence[Case]]) -> dict[str, Float[np.ndarray, "N k"]]:
    """Relative errors of ∇f by exact factors, for each of the `RESPONSES`; cases as they come, (N, k)."""
    rows = []
    for case in [case for row in cases for case in row]:
        at = Measured(case)
        measured, frozen = at.estimate(IMPLICIT), at.estimate(IMPLICIT, frozen=True)
        # Without a response ∇f is its own first part.
        rows.append([at.error(each) for each in (measured.through_learner, measured.value, frozen.value)])
    table = np.reshape(rows, (len(cases), -1, len(RESPONSES)))
    return {name: table[..., number] for number, name in enumerate(RESPONSES)}


@dataclass(frozen=True)
class Group:
    """Cases of one kind, one for each (seed, size), with the estimators tried on them."""

    cases: Sequence[tuple[int, Size]]
    forward_model: ForwardModel
    lower_level: LowerLevel
    on_sphere: bool
    estimators: Sequence[str]

    @cached_property
    def at(self) -> list[Measured]:
        """Every case, measured."""
        norm, regularisation = (OUTSIDE, WEAK_REGULARISATION) if self.on_sphere else (INSIDE, REGULARISATION)
        drawn = [
            Case.draw(seed, size, regularisation, norm, lower_level=self.lower_level, forward_model=self.forward_model)
            for seed, size in self.cases
        ]
        return [Measured(case) for case in drawn]

    @property
    def name(self) -> str:
        """In words."""
        return f"{MODELS[self.forward_model]}, `{self.lower_level}`, {'on the sphere' if self.on_sphere else 'inside'}"

    def worst_errors(self) -> list[Measurement]:
        """The largest relative error of every estimator's ∇f."""
        return [
            Measurement(
                f"{self.name}: worst relative error of ∇f, {name}",
                max(each.error(each.estimate(ESTIMATORS[name]).value) for each in self.at),
                at_most=TOLERANCE,
            )
            for name in self.estimators
        ]

    def misplaced(self) -> int:
        """How many cases are on the sphere and should be inside, or the other way round."""
        return sum(bool(each.brute.lower.active) != self.on_sphere for each in self.at)

    def responses(self) -> list[Measurement]:
        """How well Lemma 2 gives dθ_e*/dθ_l, and what its slips cost."""
        error = "relative error of dθ_e*/dθ_l"
        worst = max(each.response_error() for each in self.at)
        if self.on_sphere:
            name, value = (
                f", the multiplier left out: median {error}",
                median([each.response_error(with_multiplier=False) for each in self.at]),
            )
        elif self.lower_level == "played":
            name, value = (
                f", demonstrations held: median {error}",
                median([each.response_error(frozen=True) for each in self.at]),
            )
        else:
            name, value = (
                ": largest asymmetry ‖H - Hᵀ‖ / ‖H + Hᵀ‖",
                max(asymmetry(each.mixed_and_hessian()[1]) for each in self.at),
            )
        return [Measurement(f"{self.name}: worst {error}", worst), Measurement(self.name + name, value)]


def check(quick: bool) -> Finding:
    """Lemma 2 on random games, under both forward models; quick, what takes long to compile under eq. 5-7 alone."""
    seeds = range(2) if quick else range(6)
    cases = [(seed, size) for size in SIZES[: 1 if quick else 2] for seed in seeds]
    strengths = [1e-4, 1e-2, 1.0] if quick else [1e-4, 1e-3, 1e-2, 0.1, 1.0]
    shares = [0.03, 0.3, 1.0] if quick else [0.01, 0.03, 0.1, 0.3, 1.0]
    groups = [
        Group(cases, "logit", "played", on_sphere, UNSYMMETRIC[:1] if quick else tuple(ESTIMATORS))
        for on_sphere in (False, True)
    ]
    in_full = [
        Group(cases, "soft_joint", "played", on_sphere, tuple(ESTIMATORS))
        for on_sphere in ((False,) if quick else (False, True))
    ]
    in_full.append(Group(cases, "soft_joint", "equilibrium", False, UNSYMMETRIC[:1] if quick else UNSYMMETRIC))
    if not quick:
        in_full = [*groups, Group(cases, "logit", "equilibrium", False, UNSYMMETRIC), *in_full]
        groups = []
    groups += in_full
    every = [each for group in groups for each in group.at]

    by_strength = errors_of_responses([[Case.draw(seed, SIZES[0], each) for each in strengths] for seed in seeds])
    by_share = errors_of_responses(
        [[Case.draw(seed, SIZES[0], WEAK_REGULARISATION, unexpressed=each) for each in shares] for seed in seeds]
    )
    # For larger λ the error is no longer proportional to it.
    weak = [each for each in strengths if each <= 0.01]
    slopes = [fitted_slope(weak, row[: len(weak)]) for row in by_strength["well_specified"]]

    measurements = [
        *(each for group in groups for each in group.worst_errors()),
        Measurement(
            "r_e partly outside the reward class, response `measured`: worst relative error of ∇f, Implicit",
            float(by_share["measured"].max()),
            at_most=TOLERANCE,
        ),
        Measurement(
            "largest projected gradient that the solutions of the lower level leave",
            max(float(each.brute.lower.residual) for each in every),
            at_most=1e-12,
        ),
        Measurement(
            "games whose θ_e* is on the other side of the ball's surface than said here",
            float(sum(group.misplaced() for group in groups)),
            at_most=0.0,
        ),
        Measurement(
            "smallest multiplier on the sphere",
            min(
                float(each.brute.lower.constraint.multiplier)
                for group in groups
                if group.on_sphere
                for each in group.at
            ),
            at_least=1e-3,
        ),
        *(each for group in in_full for each in group.responses()),
        *extremes(
            f"log-log slope of the error of `well_specified` against λ ≤ {weak[-1]:g}", slopes, "of the games", 0.9, 1.1
        ),
        *(
            Measurement(f"median relative error of ∇f at λ = {each:g}, {name}", median(column))
            for name, table in (
                ("`well_specified`", by_strength["well_specified"]),
                ("demonstrations held", by_strength["demonstrations held fixed (the paper)"]),
            )
            for each, column in zip(strengths, table.T, strict=True)
        ),
        *(
            Measurement(
                f"median relative error of ∇f with a part of size {each:g} of r_e outside the class, `well_specified`",
                median(column),
            )
            for each, column in zip(shares, by_share["well_specified"].T, strict=True)
        ),
    ]
    return Finding(
        key="lemma-2",
        title="The derivative through the expert's response",
        claim=(
            "With dD/dθ_l measured from further demonstrations, Lemma 2 is the derivative of f(θ_l, θ_e*(θ_l)): inside "
            "the unit ball; on its sphere, with H plus the ball's multiplier on the tangent space; and for an H that "
            "is not symmetric. Where the reward class can express r_e, leaving the response out costs O(λ)."
        ),
        printed=(
            "The paper leaves out 1/τ, holds the demonstrations fixed although they are collected under θ_l, and "
            "differentiates as if the ball of θ_e never bound."
        ),
        reading=(
            "Errors are relative to differences of f with the lower level solved again, to rounding, from "
            f"demonstrations collected at each θ_l; inside, ‖θ_true‖ = {INSIDE:g} and λ = {REGULARISATION:g}, on the "
            f"sphere {OUTSIDE:g} and {WEAK_REGULARISATION:g}. What is left of the error of `measured` is that of "
            "measuring dD/dθ_l by differences. First figure: the error of the default `well_specified` goes to zero "
            "with λ, that of demonstrations held fixed does not. Second figure, the limit of the default: where no θ_e "
            "expresses a part of r_e (features have standard deviation 1), its error grows with that part, and only "
            f"`measured` stays right. Both under the logit equilibrium; curves are medians over {len(seeds)} games."
        ),
        measurements=measurements,
        panels=[
            _panel("r_e in the reward class", "regularisation λ", strengths, by_strength, with_guide=True),
            _panel(
                f"r_e partly outside it, λ = {WEAK_REGULARISATION:g}",
                "standard deviation of the part of r_e outside the class",
                shares,
                by_share,
            ),
        ],
    )


def asymmetry(matrix: Float[Array, "m m"]) -> float:
    """‖H − Hᵀ‖ / ‖H + Hᵀ‖."""
    return float(jnp.linalg.norm(matrix - matrix.T) / jnp.linalg.norm(matrix + matrix.T))


def _panel(
    title: str, x_label: str, x: list[float], errors: dict[str, Float[np.ndarray, "N k"]], with_guide: bool = False
) -> Panel:
    curves = [curve(name, x, np.median(table, axis=0), RESPONSES[name]) for name, table in errors.items()]
    if with_guide:
        curves.append(guide("slope 1", x, curves[0].y[0], 1.0))
    return Panel(title, x_label, "relative error of ∇f", curves)
