"""Lemma 2 in full against brute force: d f(θ_l, θ_e*(θ_l)) / dθ_l, inside the unit ball and on its sphere.

Brute force solves the lower level again at every θ_l, from the demonstrations collected there:

    θ_l → π_l played at (θ_l, θ̄_e) → D: the true expert's response to it → θ_e*(θ_l) → f(θ_l, θ_e*(θ_l))

and takes central differences of the whole. θ̄_e, the estimate believed when D is collected, is held, as Algorithm 1
holds it. Under `equilibrium` (the paper) both sides of D follow the forward model at (θ_l, true r_e).
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Literal

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.bilevel import Bilevel, LowerLevel
from gsiirl.equilibria.response import respond
from gsiirl.equilibria.soft_joint import SoftJoint
from gsiirl.games.payoff import DensePayoff
from gsiirl.hypergradients.finite_difference import FiniteDifference, coordinate_jacobian
from gsiirl.hypergradients.hvp_cg import HessianVectorCG
from gsiirl.hypergradients.implicit import Implicit
from gsiirl.hypergradients.linear_solve import BallConstraint, solve_dense
from gsiirl.hypergradients.problem import AbstractEstimator, BilevelProblem, Hypergradient
from gsiirl.irl.expectations import reward_gradient_expectation
from gsiirl.runs.findings import Curve, Finding, Measurement, Panel
from gsiirl.theory.support.games import DISCOUNT, SIZES, TEMPERATURE, RandomProblem, Size
from gsiirl.theory.support.lower_solution import LowerSolution, solve_lower
from gsiirl.theory.support.slopes import fitted_slope, guide
from gsiirl.types import Policies, Sides

TOLERANCE = 1e-5
REGULARISATION = 0.1
"""Large enough for θ_e* to move with θ_l inside the ball."""
WEAK_REGULARISATION = 1e-3
"""Small enough not to pull into the ball what lies outside, and for the error of `well_specified` by λ not to show."""
INSIDE, OUTSIDE = 0.5, 1.6
"""‖θ_true‖ where the ball is not to bind, and where it is."""
DIFFERENCE_STEP = 1e-3
"""Of brute force; its error is O(step⁴)."""
PROBE_STEP = 1e-4
"""Between the θ_l at which demonstrations are collected for `measured`."""


ForwardModel = Literal["logit", "soft_joint"]


class Game(RandomProblem):
    """A random game whose true r_e has a part `unexpressed` (S, A_l, A_e) by any θ_e, and its forward model."""

    unexpressed: Float[Array, "S A_l A_e"]
    forward_model: ForwardModel = eqx.field(static=True)

    def bilevel(self, regularisation: float, lower_level: LowerLevel = "played") -> Bilevel:
        bilevel = super().bilevel(regularisation, lower_level)
        if self.forward_model == "logit":
            return bilevel
        return eqx.tree_at(lambda each: each.forward_model, bilevel, SoftJoint(TEMPERATURE))

    def true_expert_reward(self) -> DensePayoff:
        return super().true_expert_reward() + DensePayoff(self.unexpressed)

    def interaction(self, bilevel: Bilevel, commitment: Float[Array, " n"], believed: Float[Array, " m"]) -> Policies:
        """What both sides do while D is collected."""
        if bilevel.lower_level == "equilibrium":
            true = Sides(bilevel.committed_reward(commitment), self.true_expert_reward())
            return bilevel.forward_model.solve(self.game, true, DISCOUNT).policies
        played = bilevel.solve(commitment, believed).policies.learner
        return Sides(played, respond(self.game, played, self.true_expert_reward(), TEMPERATURE, DISCOUNT).policy)

    def demonstrated(
        self, bilevel: Bilevel, commitment: Float[Array, " n"], believed: Float[Array, " m"]
    ) -> Float[Array, " m"]:
        return self.features_met(bilevel, self.interaction(bilevel, commitment, believed))

    def features_met(self, bilevel: Bilevel, policies: Policies) -> Float[Array, " m"]:
        """μ_e."""
        return reward_gradient_expectation(self.game, bilevel.expert_reward, policies, DISCOUNT)


@dataclass(frozen=True)
class Case:
    """A game with the θ_l at which the derivative is taken and the θ̄_e believed there."""

    game: Game
    commitment: Float[Array, " n"]
    believed: Float[Array, " m"]
    lower_level: LowerLevel = "played"
    regularisation: float = REGULARISATION

    @classmethod
    def draw(
        cls,
        seed: int,
        size: Size,
        true_norm: float = INSIDE,
        unexpressed: float = 0.0,
        lower_level: LowerLevel = "played",
        regularisation: float = REGULARISATION,
        forward_model: ForwardModel = "logit",
    ) -> "Case":
        """`unexpressed` is the standard deviation of what no θ_e expresses of r_e."""
        random = np.random.default_rng((seed, 2))
        base = RandomProblem.draw(seed, size, true_norm)
        parts = {field.name: getattr(base, field.name) for field in fields(base)}
        noise = jnp.asarray(random.normal(size=base.accessed.shape))
        commitment, believed = (
            jnp.asarray(0.7 * direction / np.linalg.norm(direction))
            for direction in (random.normal(size=size.learner_parameters), random.normal(size=size.expert_parameters))
        )
        return cls(
            game=Game(**parts, unexpressed=unexpressed * noise, forward_model=forward_model),
            commitment=commitment,
            believed=believed,
            lower_level=lower_level,
            regularisation=regularisation,
        )


# --- brute force -----------------------------------------------------------------------------------------------------


class BruteForce(eqx.Module):
    """θ_e* and μ̂_e(D) at the point, and the total derivatives of f and of θ_e* by differences of whole solutions."""

    lower: LowerSolution
    demonstrated: Float[Array, " m"]
    gradient: Float[Array, " n"]
    response: Float[Array, "m n"]


def solved_anew(
    game: Game,
    commitment: Float[Array, " n"],
    believed: Float[Array, " m"],
    regularisation: Float[Array, ""],
    lower_level: LowerLevel,
) -> tuple[Float[Array, ""], LowerSolution, Float[Array, " m"]]:
    """f(θ_l, θ_e*(θ_l)) and θ_e*(θ_l), from demonstrations collected at θ_l, and their μ̂_e."""
    bilevel = game.bilevel(0.0, lower_level)
    interaction = game.interaction(bilevel, commitment, believed)
    demonstrated = game.features_met(bilevel, interaction)

    def gradient(theta: Array) -> Array:
        if lower_level == "played":
            answer = respond(game.game, interaction.learner, bilevel.expert_reward.payoff(theta), TEMPERATURE, DISCOUNT)
            modelled = Sides(interaction.learner, answer.policy)
        else:
            modelled = bilevel.solve(commitment, theta).policies
        return (game.features_met(bilevel, modelled) - demonstrated) / TEMPERATURE + regularisation * theta

    lower = solve_lower(gradient, game.true_parameters)
    return bilevel.objective(commitment, lower.parameters), lower, demonstrated


@eqx.filter_jit
def _brute_force(
    game: Game,
    commitment: Float[Array, " n"],
    believed: Float[Array, " m"],
    regularisation: Float[Array, ""],
    lower_level: LowerLevel,
) -> BruteForce:
    moves = DIFFERENCE_STEP * jnp.eye(commitment.shape[0], dtype=commitment.dtype)
    offsets = jnp.concatenate([0.0 * moves[:1], moves, -moves, 2.0 * moves, -2.0 * moves])
    objectives, lower, demonstrated = jax.vmap(
        lambda theta: solved_anew(game, theta, believed, regularisation, lower_level)
    )(commitment[None, :] + offsets)

    def derivative(values: Array) -> Array:
        """Differences of widths h and 2h together: their errors of order h² cancel."""
        forth, back, far_forth, far_back = jnp.split(values[1:], 4)
        return (8.0 * (forth - back) - (far_forth - far_back)) / (12.0 * DIFFERENCE_STEP)

    return BruteForce(
        lower=jax.tree.map(lambda leaf: leaf[0], lower),
        demonstrated=demonstrated[0],
        gradient=derivative(objectives),
        response=derivative(lower.parameters).T,
    )


def brute_force(case: Case) -> BruteForce:
    """What Lemma 2 must give."""
    return _brute_force(
        case.game, case.commitment, case.believed, jnp.asarray(case.regularisation), lower_level=case.lower_level
    )


# --- Lemma 2 ---------------------------------------------------------------------------------------------------------


@eqx.filter_jit
def _demonstration_jacobian(
    game: Game, commitment: Float[Array, " n"], believed: Float[Array, " m"], lower_level: LowerLevel
) -> Float[Array, "m n"]:
    """dμ̂_e(D(θ_l))/dθ_l, measured from demonstrations at θ_l ± `PROBE_STEP` along every coordinate."""
    bilevel = game.bilevel(0.0, lower_level)
    return coordinate_jacobian(lambda theta: game.demonstrated(bilevel, theta, believed), commitment, PROBE_STEP)


def _problem(
    game: Game,
    believed: Float[Array, " m"],
    demonstrations: tuple[Float[Array, " m"], Float[Array, "m n"]],
    regularisation: Float[Array, ""],
    lower_level: LowerLevel,
) -> BilevelProblem:
    problem = game.bilevel(0.0, lower_level).problem(believed, *demonstrations)
    # λ is an argument, so that one program serves all of them.
    return eqx.tree_at(lambda each: each.regularisation, problem, regularisation)


@eqx.filter_jit
def _estimate(
    estimator: AbstractEstimator,
    game: Game,
    commitment: Float[Array, " n"],
    expert_parameters: Float[Array, " m"],
    believed: Float[Array, " m"],
    demonstrations: tuple[Float[Array, " m"], Float[Array, "m n"]],
    regularisation: Float[Array, ""],
    lower_level: LowerLevel,
) -> Hypergradient:
    problem = _problem(game, believed, demonstrations, regularisation, lower_level)
    # None of the estimators checked here is random or remembers anything.
    return estimator.estimate(
        problem, commitment, expert_parameters, None, jax.random.key(0), jnp.zeros((), jnp.int32)
    )[0]


@eqx.filter_jit
def _derivatives(
    game: Game,
    commitment: Float[Array, " n"],
    expert_parameters: Float[Array, " m"],
    believed: Float[Array, " m"],
    demonstrations: tuple[Float[Array, " m"], Float[Array, "m n"]],
    regularisation: Float[Array, ""],
    lower_level: LowerLevel,
) -> Float[Array, "m k"]:
    """M and H side by side, the demonstrations held; k = n + m."""
    problem = _problem(game, believed, demonstrations, regularisation, lower_level)
    size = commitment.shape[0]
    return jax.jacfwd(lambda both: problem.lower_gradient(both[:size], both[size:]))(
        jnp.concatenate([commitment, expert_parameters])
    )


class Measured:
    """Lemma 2 at the θ_e* that brute force found."""

    def __init__(self, case: Case) -> None:
        self.case, self.brute = case, brute_force(case)
        jacobian = _demonstration_jacobian(case.game, case.commitment, case.believed, lower_level=case.lower_level)
        self._moving = self.brute.demonstrated, jacobian
        self._held = self.brute.demonstrated, jnp.zeros_like(jacobian)

    def estimate(self, estimator: AbstractEstimator, frozen: bool = False) -> Hypergradient:
        """∇f by an estimator of response `measured`; `frozen` gives it demonstrations that do not move."""
        case = self.case
        return _estimate(
            estimator,
            case.game,
            case.commitment,
            self.brute.lower.parameters,
            case.believed,
            self._held if frozen else self._moving,
            jnp.asarray(case.regularisation),
            lower_level=case.lower_level,
        )

    def error(self, found: Float[Array, " n"]) -> float:
        """Relative error of a ∇f."""
        return relative_error(found, self.brute.gradient)

    def mixed_and_hessian(self) -> tuple[Float[Array, "m n"], Float[Array, "m m"]]:
        """M with the demonstrations held, and H."""
        case = self.case
        both = _derivatives(
            case.game,
            case.commitment,
            self.brute.lower.parameters,
            case.believed,
            self._held,
            jnp.asarray(case.regularisation),
            lower_level=case.lower_level,
        )
        return both[:, : case.commitment.shape[0]], both[:, case.commitment.shape[0] :]

    def response_error(self, frozen: bool = False, with_multiplier: bool = True) -> float:
        """Relative error of dθ_e*/dθ_l = −H⁻¹M, on the sphere −P (P (H + νI) P)⁺ P M; without ν if so told."""
        mixed, hessian = self.mixed_and_hessian()
        moved = 0.0 if frozen else self._moving[1] / TEMPERATURE
        constraint = self.brute.lower.constraint
        if not with_multiplier:
            constraint = BallConstraint(constraint.normal, 0.0 * constraint.multiplier, constraint.active)
        columns = [-solve_dense(hessian, column, constraint).solution for column in (mixed - moved).T]
        return relative_error(jnp.stack(columns, axis=1), self.brute.response)


def relative_error(found: Array, exact: Array) -> float:
    """‖found − exact‖ / ‖exact‖ (Frobenius)."""
    return float(jnp.linalg.norm(found - exact) / jnp.linalg.norm(exact))


# --- the check -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Responses:
    """Relative errors of ∇f, cases along the first axis and what is varied along the second."""

    measured: Float[np.ndarray, "N k"]
    frozen: Float[np.ndarray, "N k"]
    well_specified: Float[np.ndarray, "N k"]


def errors_of_responses(cases: Sequence[Sequence[Case]]) -> Responses:
    """Of all three responses with exact factors."""
    rows = []
    for row in cases:
        for case in row:
            at = Measured(case)
            measured, frozen = at.estimate(IMPLICIT), at.estimate(IMPLICIT, frozen=True)
            # Without a response ∇f is its own first part.
            rows.append([at.error(each) for each in (measured.value, frozen.value, measured.through_learner)])
    table = np.reshape(rows, (len(cases), -1, 3))
    return Responses(table[..., 0], table[..., 1], table[..., 2])


IMPLICIT = Implicit("measured")
ESTIMATORS: dict[str, AbstractEstimator] = {
    "Implicit": IMPLICIT,
    "HessianVectorCG": HessianVectorCG("measured"),
    "FiniteDifference": FiniteDifference("measured"),
}
UNSYMMETRIC = ("Implicit", "FiniteDifference")
"""The estimators that do not need H to be symmetric."""
MODELS: dict[ForwardModel, str] = {"logit": "logit equilibrium", "soft_joint": "eq. 5-7"}


@dataclass(frozen=True)
class Group:
    """Cases of one kind, with the estimators tried on them."""

    forward_model: ForwardModel
    lower_level: LowerLevel
    on_sphere: bool
    estimators: Sequence[str]
    at: list[Measured]

    @classmethod
    def draw(
        cls,
        cases: Sequence[tuple[int, Size]],
        forward_model: ForwardModel,
        lower_level: LowerLevel,
        on_sphere: bool,
        estimators: Sequence[str],
    ) -> "Group":
        """One for each (seed, size) of `cases`."""
        norm, regularisation = (OUTSIDE, WEAK_REGULARISATION) if on_sphere else (INSIDE, REGULARISATION)
        drawn = [
            Case.draw(
                seed,
                size,
                norm,
                lower_level=lower_level,
                regularisation=regularisation,
                forward_model=forward_model,
            )
            for seed, size in cases
        ]
        return cls(forward_model, lower_level, on_sphere, estimators, [Measured(case) for case in drawn])

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
        found = [
            Measurement(
                f"{self.name}: worst relative error of dθ_e*/dθ_l", max(each.response_error() for each in self.at)
            )
        ]
        if self.on_sphere:
            without = _median([each.response_error(with_multiplier=False) for each in self.at])
            found.append(
                Measurement(f"{self.name}, the multiplier left out: median relative error of dθ_e*/dθ_l", without)
            )
        elif self.lower_level == "played":
            held = _median([each.response_error(frozen=True) for each in self.at])
            found.append(Measurement(f"{self.name}, demonstrations held: median relative error of dθ_e*/dθ_l", held))
        else:
            largest = max(asymmetry(each.mixed_and_hessian()[1]) for each in self.at)
            found.append(Measurement(f"{self.name}: largest asymmetry ‖H - Hᵀ‖ / ‖H + Hᵀ‖", largest))
        return found


def check(quick: bool) -> Finding:
    """Lemma 2 on random games, under both forward models; quick, what takes long to compile under eq. 5-7 alone."""
    seeds = range(2) if quick else range(6)
    cases = [(seed, size) for size in SIZES[: 1 if quick else 2] for seed in seeds]
    strengths = [1e-4, 1e-2, 1.0] if quick else [1e-4, 1e-3, 1e-2, 0.1, 1.0]
    shares = [0.03, 0.3, 1.0] if quick else [0.01, 0.03, 0.1, 0.3, 1.0]
    groups = [
        Group.draw(cases, "logit", "played", on_sphere, UNSYMMETRIC[:1] if quick else tuple(ESTIMATORS))
        for on_sphere in (False, True)
    ]
    in_full = [
        Group.draw(cases, "soft_joint", "played", on_sphere, tuple(ESTIMATORS))
        for on_sphere in ((False,) if quick else (False, True))
    ]
    in_full.append(Group.draw(cases, "soft_joint", "equilibrium", False, UNSYMMETRIC[:1] if quick else UNSYMMETRIC))
    if not quick:
        in_full = [*groups, Group.draw(cases, "logit", "equilibrium", False, UNSYMMETRIC), *in_full]
        groups = []
    groups += in_full
    every = [each for group in groups for each in group.at]

    by_strength = errors_of_responses(
        [[Case.draw(seed, SIZES[0], regularisation=each) for each in strengths] for seed in seeds]
    )
    by_share = errors_of_responses(
        [
            [Case.draw(seed, SIZES[0], unexpressed=each, regularisation=WEAK_REGULARISATION) for each in shares]
            for seed in seeds
        ]
    )
    # For larger λ the error is no longer proportional to it.
    weak = [each for each in strengths if each <= 0.01]
    slopes = [fitted_slope(weak, row[: len(weak)]) for row in by_strength.well_specified]

    measurements = [
        *(each for group in groups for each in group.worst_errors()),
        Measurement(
            "r_e partly outside the reward class, response `measured`: worst relative error of ∇f, Implicit",
            float(by_share.measured.max()),
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
        *(
            Measurement(
                f"log-log slope of the error of `well_specified` against λ ≤ {weak[-1]:g}, {word} of the games",
                value,
                at_least=0.9,
                at_most=1.1,
            )
            for word, value in (("smallest", min(slopes)), ("largest", max(slopes)))
        ),
        *(
            Measurement(f"median relative error of ∇f at λ = {each:g}, {name}", _median(column))
            for name, table in (
                ("`well_specified`", by_strength.well_specified),
                ("demonstrations held", by_strength.frozen),
            )
            for each, column in zip(strengths, table.T, strict=True)
        ),
        *(
            Measurement(
                f"median relative error of ∇f with a part of size {each:g} of r_e outside the class, `well_specified`",
                _median(column),
            )
            for each, column in zip(shares, by_share.well_specified.T, strict=True)
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


def _median(values: Sequence[float] | np.ndarray) -> float:
    return float(np.median(values))


def asymmetry(matrix: Float[Array, "m m"]) -> float:
    """‖H − Hᵀ‖ / ‖H + Hᵀ‖."""
    return float(jnp.linalg.norm(matrix - matrix.T) / jnp.linalg.norm(matrix + matrix.T))


def _panel(title: str, x_label: str, x: list[float], errors: Responses, with_guide: bool = False) -> Panel:
    def curve(name: str, table: Float[np.ndarray, "N k"], role: str = "ours") -> Curve:
        return Curve(name, x, np.median(table, axis=0).tolist(), role=role)

    curves = [
        curve("well_specified", errors.well_specified),
        curve("measured", errors.measured),
        curve("demonstrations held fixed (the paper)", errors.frozen, "paper"),
    ]
    if with_guide:
        start = curves[0].y[0]
        curves.append(guide("slope 1", x, start, 1.0))
    return Panel(title, x_label, "relative error of ∇f", curves)
