"""Differences along every coordinate: two evaluations for each of the n + m parameters."""

from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PyTree

from gsiirl.hypergradients.compose import with_response, without_response
from gsiirl.hypergradients.linear_solve import BallConstraint, solve_dense
from gsiirl.hypergradients.problem import AbstractStatelessEstimator, BilevelProblem, Hypergradient, ResponseKind
from gsiirl.hypergradients.vectors import ExpertVector, LearnerVector


class FiniteDifference(AbstractStatelessEstimator):
    """∇f with every factor from central differences of width `step` (the paper's comparison in section 7.1).

    All evaluations are one vmapped call. The error is O(step²); the system is solved with Hᵀ.
    """

    response: ResponseKind = eqx.field(static=True, default="well_specified")
    step: float = 1e-4

    def hypergradient(self, problem: BilevelProblem, learner: LearnerVector, expert: ExpertVector) -> Hypergradient:
        learner_size, expert_size = learner.shape[0], expert.shape[0]
        if self.response == "well_specified":
            gradient = coordinate_jacobian(lambda theta: problem.objective(theta, expert), learner, self.step)
            return without_response(gradient, evaluations=2 * learner_size)
        moved = problem.demonstrations_move(self.response)

        def evaluate(both: Array) -> tuple[Array, Array]:
            return problem.evaluate(both[:learner_size], both[learner_size:])

        both = jnp.concatenate([learner, expert])
        objective, gradient = coordinate_jacobian(evaluate, both, self.step)
        mixed, hessian = gradient[:, :learner_size] + moved, gradient[:, learner_size:]
        hessian = hessian + problem.regularisation * jnp.eye(expert_size, dtype=hessian.dtype)
        constraint = BallConstraint.at(expert, problem.lower_gradient(learner, expert))
        solved = solve_dense(hessian.T, objective[learner_size:], constraint)
        return with_response(
            objective[:learner_size],
            mixed.T @ solved.solution,
            solved,
            constraint,
            evaluations=2 * (learner_size + expert_size) + 1,
        )


def coordinate_jacobian(function: Callable[[Array], PyTree], point: Float[Array, " n"], step: float) -> PyTree:
    """d function / d point by central differences; each output gets a last axis of n. One vmapped call."""
    moves = step * jnp.eye(point.shape[0], dtype=point.dtype)
    values = jax.vmap(function)(jnp.concatenate([point[None, :] + moves, point[None, :] - moves]))
    size = point.shape[0]
    return jax.tree.map(lambda value: jnp.moveaxis((value[:size] - value[size:]) / (2.0 * step), 0, -1), values)
