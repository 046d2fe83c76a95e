"""d f(θ_l, θ_e*(θ_l)) / dθ_l by brute force, and Lemma 2 at the same point.

Brute force solves the lower level again at every θ_l, from the demonstrations collected there:

    θ_l → π_l played at (θ_l, θ̄_e) → D: the true expert's response to it → θ_e*(θ_l) → f(θ_l, θ_e*(θ_l))

and takes central differences of the whole. θ̄_e, the estimate believed when D is collected, is held, as Algorithm 1
holds it.
"""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.hypergradients import AbstractEstimator, Hypergradient, coordinate_jacobian
from gsiirl.hypergradients.linear_solve import BallConstraint, solve_dense
from gsiirl.learners.bilevel import LowerLevel
from gsiirl.theory.support.games import TEMPERATURE, ForwardModel, RandomProblem, Size, of_norm
from gsiirl.theory.support.lower_solution import LowerSolution, solve_lower
from gsiirl.theory.support.total_derivative import remembered

DIFFERENCE_STEP = 1e-3
"""Of brute force; its error is O(step⁴)."""
PROBE_STEP = 1e-4
"""Between the θ_l at which demonstrations are collected for the response `measured`."""
NORM = 0.7
"""‖θ_l‖ and ‖θ̄_e‖."""


class Case(eqx.Module):
    """A game with the θ_l at which the derivative is taken, the θ̄_e believed there, and λ."""

    game: RandomProblem
    commitment: Float[Array, " n"]
    believed: Float[Array, " m"]
    regularisation: Float[Array, ""]
    lower_level: LowerLevel = eqx.field(static=True, default="played")

    @classmethod
    def draw(
        cls,
        seed: int,
        size: Size,
        regularisation: float,
        true_norm: float = 0.5,
        unexpressed: float = 0.0,
        lower_level: LowerLevel = "played",
        forward_model: ForwardModel = "logit",
    ) -> "Case":
        """Game `seed` with ‖θ_true‖ = `true_norm`, and a random point.

        `unexpressed` is the standard deviation of the part of r_e that no θ_e expresses.
        """
        random = np.random.default_rng((seed, 2))
        base = RandomProblem.draw(seed, size, true_norm)
        noise = jnp.asarray(random.normal(size=base.accessed.shape))
        return cls(
            game=replace(base, unexpressed=unexpressed * noise, forward_model=forward_model),
            commitment=of_norm(random, NORM, size.learner_parameters),
            believed=of_norm(random, NORM, size.expert_parameters),
            regularisation=jnp.asarray(regularisation),
            lower_level=lower_level,
        )

    def solved_anew(self, commitment: Float[Array, " n"]) -> tuple[Array, LowerSolution, Float[Array, " m"]]:
        """f(θ_l, θ_e*(θ_l)) and θ_e*(θ_l), from demonstrations collected at θ_l, and their μ̂_e."""
        bilevel = self.game.bilevel(self.regularisation, self.lower_level)
        interaction = self.game.interaction(bilevel, commitment, self.believed)
        demonstrated = self.game.features_met(interaction)
        memory = remembered(interaction.learner, demonstrated)
        lower = solve_lower(lambda theta: bilevel.lower_gradient(commitment, theta, memory), self.game.true_parameters)
        return bilevel.objective(commitment, lower.parameters), lower, demonstrated


class BruteForce(eqx.Module):
    """θ_e* and μ̂_e(D) at the point, and the total derivatives of f and of θ_e* by differences of whole solutions."""

    lower: LowerSolution
    demonstrated: Float[Array, " m"]
    gradient: Float[Array, " n"]
    response: Float[Array, "m n"]


@eqx.filter_jit
def brute_force(case: Case) -> BruteForce:
    """What Lemma 2 must give."""
    moves = DIFFERENCE_STEP * jnp.eye(case.commitment.shape[0], dtype=case.commitment.dtype)
    offsets = jnp.concatenate([0.0 * moves[:1], moves, -moves, 2.0 * moves, -2.0 * moves])
    objectives, lower, demonstrated = jax.vmap(case.solved_anew)(case.commitment[None, :] + offsets)

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


@eqx.filter_jit
def _demonstration_jacobian(case: Case) -> Float[Array, "m n"]:
    """dμ̂_e(D(θ_l))/dθ_l, measured from demonstrations at θ_l ± `PROBE_STEP` along every coordinate."""
    bilevel = case.game.bilevel(0.0, case.lower_level)
    return coordinate_jacobian(
        lambda theta: case.game.demonstrated(bilevel, theta, case.believed), case.commitment, PROBE_STEP
    )


@eqx.filter_jit
def _estimate(
    estimator: AbstractEstimator, case: Case, brute: BruteForce, demonstration_jacobian: Float[Array, "m n"]
) -> Hypergradient:
    bilevel = case.game.bilevel(case.regularisation, case.lower_level)
    problem = bilevel.problem(case.believed, brute.demonstrated, demonstration_jacobian)
    # None of the estimators checked here is random or remembers anything.
    key, first = jax.random.key(0), jnp.zeros((), jnp.int32)
    return estimator.estimate(problem, case.commitment, brute.lower.parameters, None, key, first)[0]


@eqx.filter_jit
def _derivatives(case: Case, brute: BruteForce) -> tuple[Float[Array, "m n"], Float[Array, "m m"]]:
    problem = case.game.bilevel(case.regularisation, case.lower_level).problem(case.believed, brute.demonstrated)
    size = case.commitment.shape[0]
    both = jax.jacfwd(lambda both: problem.lower_gradient(both[:size], both[size:]))(
        jnp.concatenate([case.commitment, brute.lower.parameters])
    )
    return both[:, :size], both[:, size:]


class Measured:
    """Lemma 2 at the θ_e* that brute force found."""

    def __init__(self, case: Case) -> None:
        self.case, self.brute = case, brute_force(case)
        self._moving = _demonstration_jacobian(case)

    def estimate(self, estimator: AbstractEstimator, frozen: bool = False) -> Hypergradient:
        """∇f by an estimator of response `measured`; `frozen` gives it demonstrations that do not move."""
        return _estimate(estimator, self.case, self.brute, 0.0 * self._moving if frozen else self._moving)

    def error(self, found: Float[Array, " n"]) -> float:
        """Relative error of a ∇f."""
        return relative_error(found, self.brute.gradient)

    def mixed_and_hessian(self) -> tuple[Float[Array, "m n"], Float[Array, "m m"]]:
        """M with the demonstrations held, and H."""
        return _derivatives(self.case, self.brute)

    def response_error(self, frozen: bool = False, with_multiplier: bool = True) -> float:
        """Relative error of dθ_e*/dθ_l = −H⁻¹M, on the sphere −P (P (H + νI) P)⁺ P M; without ν if so told."""
        mixed, hessian = self.mixed_and_hessian()
        moved = 0.0 if frozen else self._moving / TEMPERATURE
        constraint = self.brute.lower.constraint
        if not with_multiplier:
            constraint = BallConstraint(constraint.normal, 0.0 * constraint.multiplier, constraint.active)
        columns = [-solve_dense(hessian, column, constraint).solution for column in (mixed - moved).T]
        return relative_error(jnp.stack(columns, axis=1), self.brute.response)


def relative_error(found: Array, exact: Array) -> float:
    """‖found − exact‖ / ‖exact‖ (Frobenius)."""
    return float(jnp.linalg.norm(found - exact) / jnp.linalg.norm(exact))
