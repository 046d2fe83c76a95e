"""A quadratic bilevel problem, whose hypergradient is known in closed form.

    L(l, e) = ½ eᵀHe + eᵀMl − c(l)ᵀe + (λ/2)‖e‖²,     c(l) = c_0 + Cl,     ‖e‖ ≤ 1
    f(l, e) = aᵀl + bᵀe + ½ lᵀPl + lᵀQe + ½ eᵀRe

c(l) stands for the demonstrations, which move with l: `frozen` holds them, `measured` does not. There is no game, and
the closed form is numpy.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from gsiirl.hypergradients import BilevelProblem, ResponseKind

LEARNER_SIZE, EXPERT_SIZE = 5, 4
REGULARISATION = 0.1


class Quadratic(eqx.Module):
    """One such problem at the point l, with everything that is known of it in closed form.

    Its arrays are numpy's; inside a compiled program they are JAX's, and only `problem` is asked there.
    """

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
        root, learner_root, expert_root = (random.normal(size=(size, size)) for size in (m, n, m))
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

    @property
    def solution(self) -> tuple[np.ndarray, float]:
        """e* and ν at the point."""
        return self.lower_solution(self.point, self.point)

    def response(self, kind: ResponseKind) -> np.ndarray:
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

    def response_by_differences(self, kind: ResponseKind, step: float = 3e-3) -> np.ndarray:
        """de*/dl from solving again at l ± step, 2 step, 3 step along each coordinate; error O(step⁶)."""
        columns = []
        for move in step * np.eye(LEARNER_SIZE):
            solutions = [
                weight * (self._moved(kind, number * move) - self._moved(kind, -number * move))
                for number, weight in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
            ]
            columns.append(np.sum(solutions, axis=0) / step)
        return np.stack(columns, axis=1)

    def response_error(self, kind: ResponseKind) -> float:
        """How far the closed form of de*/dl is from differences of e*, relative."""
        closed = self.response(kind)
        return float(np.linalg.norm(self.response_by_differences(kind) - closed) / np.linalg.norm(closed))

    def _moved(self, kind: ResponseKind, move: np.ndarray) -> np.ndarray:
        there = self.point + move
        return self.lower_solution(there, there if kind == "measured" else self.point)[0]

    def objective_gradients(self) -> tuple[np.ndarray, np.ndarray]:
        """∇_l f and ∇_e f at (l, e*)."""
        solution = self.solution[0]
        return (
            self.learner_slope + self.learner_curvature @ self.point + self.cross @ solution,
            self.expert_slope + self.cross.T @ self.point + self.expert_curvature @ solution,
        )

    def hypergradient(self, kind: ResponseKind) -> np.ndarray:
        """∇f = ∇_l f + (de*/dl)ᵀ ∇_e f."""
        learner, expert = self.objective_gradients()
        return learner + self.response(kind).T @ expert

    def problem(self) -> BilevelProblem:
        """What the estimators take, the demonstrations held."""

        def evaluate(learner: Array, expert: Array) -> tuple[Array, Array]:
            objective = (
                jnp.vdot(self.learner_slope, learner)
                + jnp.vdot(self.expert_slope, expert)
                + 0.5 * jnp.vdot(learner, self.learner_curvature @ learner)
                + jnp.vdot(learner, self.cross @ expert)
                + 0.5 * jnp.vdot(expert, self.expert_curvature @ expert)
            )
            demonstrated = self.offset + self.moving @ self.point
            return objective, jnp.asarray(self.likelihood_hessian @ expert + self.mixed @ learner - demonstrated)

        return BilevelProblem(
            evaluate=evaluate,
            regularisation=REGULARISATION,
            upper_gradient=lambda learner, expert: jnp.asarray(self.mixed.T @ expert),
            demonstration_jacobian=jnp.asarray(self.moving),
        )
