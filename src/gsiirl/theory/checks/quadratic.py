"""The estimators of the hypergradient on a quadratic bilevel problem, whose answer is known in closed form.

    L(l, e) = ½ eᵀHe + eᵀMl − c(l)ᵀe + (λ/2)‖e‖²,     c(l) = c_0 + Cl,     ‖e‖ ≤ 1
    f(l, e) = aᵀl + bᵀe + ½ lᵀPl + lᵀQe + ½ eᵀRe

c(l) stands for the demonstrations, which move with l: `frozen` holds them, `measured` does not. There is no game, and
everything that the estimators are compared with is numpy.
"""

from dataclasses import dataclass
from functools import cached_property

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.hypergradients import (
    SPSA,
    AbstractEstimator,
    BilevelProblem,
    FiniteDifference,
    HessianVectorCG,
    Implicit,
    Response,
)
from gsiirl.hypergradients.spsa import Factors
from gsiirl.runs.findings import Curve, Finding, Measurement, Panel
from gsiirl.theory.support.slopes import fitted_slope

LEARNER_SIZE, EXPERT_SIZE = 5, 4
REGULARISATION = 0.1
STEP = 1e-2
"""Central differences of a quadratic are exact at any step: a large one leaves the least rounding."""
FACTOR_DRAWS, FACTOR_SEED, REACH = 10_000, 0, 0.05
KEYS, COMPOSED_SEED = 64, 1
PRINTED_DRAWS, PRINTED_SEED = 2000, 2


@dataclass(frozen=True)
class Quadratic:
    """One such problem at the point l, with everything that is known of it in closed form."""

    likelihood_hessian: np.ndarray
    mixed: np.ndarray
    offset: np.ndarray
    moving: np.ndarray
    learner_slope: np.ndarray
    expert_slope: np.ndarray
    learner_curvature: np.ndarray
    cross: np.ndarray
    expert_curvature: np.ndarray
    point: np.ndarray

    @classmethod
    def draw(cls, seed: int, on_sphere: bool) -> "Quadratic":
        """Normal entries, H = AAᵀ/m + I/4; the unconstrained lower solution has norm 0.5, or 2 with `on_sphere`."""
        random = np.random.default_rng(seed)
        n, m = LEARNER_SIZE, EXPERT_SIZE
        root, learner_root, expert_root = (
            random.normal(size=(m, m)),
            random.normal(size=(n, n)),
            random.normal(size=(m, m)),
        )
        hessian = root @ root.T / m + 0.25 * np.eye(m)
        mixed, moving, point = random.normal(size=(m, n)), random.normal(size=(m, n)), random.normal(size=n)
        direction = random.normal(size=m)
        wanted = (2.0 if on_sphere else 0.5) * direction / np.linalg.norm(direction)
        offset = (hessian + REGULARISATION * np.eye(m)) @ wanted + (mixed - moving) @ point
        return cls(
            likelihood_hessian=hessian,
            mixed=mixed,
            offset=offset,
            moving=moving,
            learner_slope=random.normal(size=n),
            expert_slope=random.normal(size=m),
            learner_curvature=learner_root + learner_root.T,
            cross=random.normal(size=(n, m)),
            expert_curvature=expert_root + expert_root.T,
            point=point,
        )

    @property
    def hessian(self) -> np.ndarray:
        """H + λI."""
        return self.likelihood_hessian + REGULARISATION * np.eye(EXPERT_SIZE)

    def lower_solution(self, point: np.ndarray, demonstrations_at: np.ndarray) -> tuple[np.ndarray, float]:
        """e* and its multiplier ν ≥ 0: (H + (λ + ν)I) e* = c − Ml; ν by bisection where the ball binds."""
        right = self.offset + self.moving @ demonstrations_at - self.mixed @ point
        values, vectors = np.linalg.eigh(self.hessian)
        coordinates = vectors.T @ right

        def norm(multiplier: float) -> float:
            return float(np.linalg.norm(coordinates / (values + multiplier)))

        low, high = 0.0, float(np.linalg.norm(right))
        if norm(low) <= 1.0:
            return vectors @ (coordinates / values), 0.0
        # ‖e(ν)‖ falls with ν, and is below 1 at ν = ‖c − Ml‖. 100 halvings reach the last bit.
        for _ in range(100):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if norm(middle) > 1.0 else (low, middle)
        return vectors @ (coordinates / (values + high)), high

    @cached_property
    def solution(self) -> tuple[np.ndarray, float]:
        """e* and ν at the point."""
        return self.lower_solution(self.point, self.point)

    def response(self, kind: Response) -> np.ndarray:
        """de*/dl, (m, n), from the KKT conditions differentiated: [[H + (λ + ν)I, e], [eᵀ, 0]] [de; dν] = [−dG; 0]."""
        solution, multiplier = self.solution
        change = self.mixed - self.moving if kind == "measured" else self.mixed
        if multiplier == 0.0:
            return -np.linalg.solve(self.hessian, change)
        size = EXPERT_SIZE
        bordered = np.zeros((size + 1, size + 1))
        bordered[:size, :size] = self.hessian + multiplier * np.eye(size)
        bordered[:size, size] = bordered[size, :size] = solution
        return np.linalg.solve(bordered, np.vstack([-change, np.zeros((1, LEARNER_SIZE))]))[:size]

    def response_by_differences(self, kind: Response, step: float = 3e-3) -> np.ndarray:
        """de*/dl from solving again at l ± step, 2 step, 3 step along each coordinate; error O(step⁶)."""
        columns = []
        for move in step * np.eye(LEARNER_SIZE):
            solutions = [
                weight * (self._moved(kind, number * move) - self._moved(kind, -number * move))
                for number, weight in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
            ]
            columns.append(np.sum(solutions, axis=0) / step)
        return np.stack(columns, axis=1)

    def response_error(self, kind: Response) -> float:
        """How far the closed form of de*/dl is from differences of e*, relative."""
        closed = self.response(kind)
        return float(np.linalg.norm(self.response_by_differences(kind) - closed) / np.linalg.norm(closed))

    def _moved(self, kind: Response, move: np.ndarray) -> np.ndarray:
        there = self.point + move
        return self.lower_solution(there, there if kind == "measured" else self.point)[0]

    def objective_gradients(self) -> tuple[np.ndarray, np.ndarray]:
        """∇_l f and ∇_e f at (l, e*)."""
        solution = self.solution[0]
        return (
            self.learner_slope + self.learner_curvature @ self.point + self.cross @ solution,
            self.expert_slope + self.cross.T @ self.point + self.expert_curvature @ solution,
        )

    def hypergradient(self, kind: Response) -> np.ndarray:
        """∇f = ∇_l f + (de*/dl)ᵀ ∇_e f."""
        learner, expert = self.objective_gradients()
        return learner + self.response(kind).T @ expert

    def arrays(self) -> "QuadraticProblem":
        """The same problem for the estimators."""
        return QuadraticProblem(
            *(
                jnp.asarray(each)
                for each in (
                    self.likelihood_hessian,
                    self.mixed,
                    self.offset + self.moving @ self.point,
                    self.moving,
                    self.learner_slope,
                    self.expert_slope,
                    self.learner_curvature,
                    self.cross,
                    self.expert_curvature,
                )
            )
        )


class QuadraticProblem(eqx.Module):
    """The matrices of a quadratic problem as arrays, the demonstrations held: one compiled program serves all."""

    likelihood_hessian: Float[Array, "m m"]
    mixed: Float[Array, "m n"]
    demonstrated: Float[Array, " m"]
    moving: Float[Array, "m n"]
    learner_slope: Float[Array, " n"]
    expert_slope: Float[Array, " m"]
    learner_curvature: Float[Array, "n n"]
    cross: Float[Array, "n m"]
    expert_curvature: Float[Array, "m m"]

    def bilevel(self) -> BilevelProblem:
        """What the estimators take."""

        def evaluate(learner: Array, expert: Array) -> tuple[Array, Array]:
            objective = (
                jnp.vdot(self.learner_slope, learner)
                + jnp.vdot(self.expert_slope, expert)
                + 0.5 * jnp.vdot(learner, self.learner_curvature @ learner)
                + jnp.vdot(learner, self.cross @ expert)
                + 0.5 * jnp.vdot(expert, self.expert_curvature @ expert)
            )
            return objective, self.likelihood_hessian @ expert + self.mixed @ learner - self.demonstrated

        return BilevelProblem(
            evaluate=evaluate,
            regularisation=REGULARISATION,
            upper_gradient=lambda learner, expert: self.mixed.T @ expert,
            demonstration_jacobian=self.moving,
        )


@eqx.filter_jit
def estimate(
    estimator: AbstractEstimator,
    problem: QuadraticProblem,
    point: Float[Array, " n"],
    solution: Float[Array, " m"],
    keys: Array,
) -> Float[Array, "keys n"]:
    """∇f once for each key."""
    state, first, held = estimator.init(solution), jnp.asarray(0), problem.bilevel()
    # One after the other: batched eigenvalues and loops take twice as long to compile.
    return jax.lax.map(lambda key: estimator.estimate(held, point, solution, state, key, first)[0].value, keys)


def estimators(response: Response) -> dict[str, AbstractEstimator]:
    """Those that are exact on a quadratic problem."""
    return {
        "Implicit": Implicit(response),
        "HessianVectorCG": HessianVectorCG(response, step=STEP, tolerance=1e-14),
        "FiniteDifference": FiniteDifference(response, step=STEP),
    }


def exact_errors(quadratics: list[Quadratic], response: Response) -> dict[str, float]:
    """The worst relative error of each exact estimator over the problems."""
    key = jax.random.key(0)[None]
    worst = {}
    for name, estimator in estimators(response).items():
        errors = []
        for each in quadratics:
            expected = each.hypergradient(response)
            found = estimate(estimator, each.arrays(), jnp.asarray(each.point), jnp.asarray(each.solution[0]), key)[0]
            errors.append(float(np.linalg.norm(np.asarray(found) - expected) / np.linalg.norm(expected)))
        worst[name] = float(np.max(errors))
    return worst


@eqx.filter_jit
def _factors(
    problem: QuadraticProblem, point: Float[Array, " n"], solution: Float[Array, " m"], key: Array, draws: int
) -> Factors:
    return SPSA("measured", draws=draws).factors(problem.bilevel(), point, solution, key, jnp.asarray(REACH))


def factor_scores(quadratic: Quadratic, seed: int, draws: int) -> np.ndarray:
    """(mean − truth) / standard error of every distinct entry of SPSA's four factors over `draws` draws."""
    point, solution = jnp.asarray(quadratic.point), jnp.asarray(quadratic.solution[0])
    drawn = _factors(quadratic.arrays(), point, solution, jax.random.key(seed), draws)
    learner, expert = quadratic.objective_gradients()
    distinct = np.triu_indices(EXPERT_SIZE)
    pairs = (
        (np.asarray(drawn.learner_gradient), learner),
        (np.asarray(drawn.expert_gradient), expert),
        (np.asarray(drawn.hessian)[:, distinct[0], distinct[1]], quadratic.likelihood_hessian[distinct]),
        (np.asarray(drawn.mixed).reshape(draws, -1), quadratic.mixed.ravel()),
    )
    return np.concatenate(
        [(samples.mean(axis=0) - truth) / (samples.std(axis=0, ddof=1) / np.sqrt(draws)) for samples, truth in pairs]
    )


def composed_errors(quadratic: Quadratic, draws: int, keys: int) -> np.ndarray:
    """The relative error of SPSA's `measured` hypergradient from `draws` draws, for each of `keys` keys."""
    expected = quadratic.hypergradient("measured")
    found = estimate(
        SPSA("measured", perturbation=REACH, draws=draws),
        quadratic.arrays(),
        jnp.asarray(quadratic.point),
        jnp.asarray(quadratic.solution[0]),
        jax.random.split(jax.random.key(COMPOSED_SEED), keys),
    )
    return np.linalg.norm(np.asarray(found) - expected, axis=1) / np.linalg.norm(expected)


def printed_hessians(quadratic: Quadratic, seed: int, draws: int) -> np.ndarray:
    """Eq. 4 as printed, `draws` times: row i is (∇_e L(e + pΔ) − ∇_e L(e − pΔ))ᵀ / 2pΔ_i with one Rademacher Δ."""
    directions = np.random.default_rng(seed).choice([-1.0, 1.0], size=(draws, EXPERT_SIZE))
    constant = quadratic.mixed @ quadratic.point - quadratic.offset - quadratic.moving @ quadratic.point

    def gradient(points: np.ndarray) -> np.ndarray:
        return points @ quadratic.hessian + constant

    solution = quadratic.solution[0]
    change = gradient(solution + REACH * directions) - gradient(solution - REACH * directions)
    return change[:, None, :] / (2.0 * REACH * directions[:, :, None])


def indefinite_fraction(matrices: np.ndarray) -> float:
    """The fraction whose symmetric part has eigenvalues of both signs, beyond rounding."""
    values = np.linalg.eigvalsh(0.5 * (matrices + np.swapaxes(matrices, 1, 2)))
    margin = 1e-10 * np.abs(values).max(axis=1)
    return float(np.mean((values[:, 0] < -margin) & (values[:, -1] > margin)))


def check(quick: bool) -> Finding:
    """Every estimator on quadratic problems."""
    numbers = range(3) if quick else range(20)
    draws = [1, 30, 1000] if quick else [1, 3, 10, 30, 100, 300, 1000, 3000, 10_000]
    inside, sphere = ([Quadratic.draw(seed, on_sphere) for seed in numbers] for on_sphere in (False, True))

    measurements = []
    for where, quadratics in (("inside the ball", inside), ("on the sphere", sphere)):
        for response in ("frozen", "measured"):
            for name, error in exact_errors(quadratics, response).items():
                measurements.append(
                    Measurement(f"{name}, {response}, {where}: worst relative error", error, at_most=1e-10)
                )
    differences = np.max([each.response_error(kind) for each in [*inside, *sphere] for kind in ("frozen", "measured")])
    measurements.append(
        Measurement(
            "closed form of de*/dl against differences of the constrained solution: worst relative error",
            float(differences),
            at_most=1e-8,
        )
    )

    scores = factor_scores(inside[0], FACTOR_SEED, FACTOR_DRAWS)
    measurements.append(
        Measurement(
            f"SPSA, mean of {FACTOR_DRAWS} draws of every factor ({scores.size} entries): "
            "largest distance from the truth, in standard errors",
            float(np.abs(scores).max()),
            at_most=4.0,
        )
    )
    errors = np.stack([composed_errors(inside[0], number, KEYS) for number in draws])
    mean = errors.mean(axis=1)
    slope = fitted_slope(draws, mean)
    measurements.append(
        Measurement("SPSA, composed hypergradient: slope of ln(error) over ln(draws)", slope, at_most=-0.3)
    )
    measurements.append(
        Measurement(f"SPSA, composed hypergradient: mean relative error at {draws[-1]} draws", float(mean[-1]))
    )
    printed = printed_hessians(inside[0], PRINTED_SEED, PRINTED_DRAWS)
    measurements.append(
        Measurement(
            f"eq. 4 as printed, {PRINTED_DRAWS} draws of the Hessian: fraction whose symmetric part is indefinite",
            indefinite_fraction(printed),
        )
    )

    x = [float(number) for number in draws]
    return Finding(
        key="quadratic",
        title="Estimators on a problem with a closed form",
        claim=(
            "On a quadratic bilevel problem Implicit, HessianVectorCG and FiniteDifference give the hypergradient to "
            "rounding, inside the unit ball and on its sphere, with the demonstrations held or moving; SPSA's factors "
            "are unbiased, and the hypergradient composed of them converges as draws are added."
        ),
        printed=(
            "Eq. 4 estimates the Hessian by one draw of a matrix of rank one that is not symmetric and hands it to "
            "conjugate gradients, which need a positive definite one."
        ),
        reading=(
            f"n = {LEARNER_SIZE}, m = {EXPERT_SIZE}, λ = {REGULARISATION:g}; {len(numbers)} problems of each kind. The "
            "closed form is numpy: the multiplier by bisection, the response from the differentiated optimality "
            "conditions. SPSA's seeds and numbers of draws were fixed beforehand. The figure gives the composed "
            f"hypergradient's relative error, mean over {KEYS} keys with its standard error as the band, beside a line "
            "of slope -1/2. The fall is steeper at first: the symmetrised Hessian of one draw has rank two at most, "
            "and λ alone then bounds what is divided by."
        ),
        measurements=measurements,
        panels=[
            Panel(
                "SPSA, all factors estimated",
                "draws",
                "relative error of the hypergradient",
                [
                    Curve("SPSA", x, mean.tolist(), (errors.std(axis=1, ddof=1) / np.sqrt(KEYS)).tolist()),
                    Curve("slope -1/2", x, (mean[-1] * np.sqrt(draws[-1] / np.asarray(draws))).tolist(), role="guide"),
                ],
            )
        ],
    )
