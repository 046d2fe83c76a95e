"""The exact hypergradient, by automatic differentiation of the solver: the oracle for all other estimators."""

import equinox as eqx
import jax
import jax.numpy as jnp

from gsiirl.hypergradients.compose import with_response, without_response
from gsiirl.hypergradients.linear_solve import BallConstraint, solve_dense
from gsiirl.hypergradients.problem import AbstractStatelessEstimator, BilevelProblem, Hypergradient, ResponseKind
from gsiirl.hypergradients.vectors import ExpertVector, LearnerVector


class Implicit(AbstractStatelessEstimator):
    """∇f with every factor exact (Lemma 2; docs/theory.md).

    H comes from m forward passes, ∇f's parts and Mᵀw from one backward pass each: no matrix of size m × n. The system
    is solved with Hᵀ, so that H need not be symmetric.
    """

    response: ResponseKind = eqx.field(static=True, default="well_specified")

    def hypergradient(self, problem: BilevelProblem, learner: LearnerVector, expert: ExpertVector) -> Hypergradient:
        if self.response == "well_specified":
            gradient = jax.grad(problem.objective)(learner, expert)
            return without_response(gradient, evaluations=1, derivatives=1)
        moved = problem.demonstrations_move(self.response)
        through_learner, through_expert = jax.grad(problem.objective, (0, 1))(learner, expert)
        lower_gradient, pull_back = jax.vjp(lambda theta: problem.lower_gradient(theta, expert), learner)
        hessian = jax.jacfwd(problem.lower_gradient, 1)(learner, expert)
        constraint = BallConstraint.at(expert, lower_gradient)
        solved = solve_dense(hessian.T, through_expert, constraint)
        (mixed_product,) = pull_back(solved.solution)
        if self.response == "measured":
            mixed_product = mixed_product + jnp.dot(solved.solution, moved)
        passes = expert.shape[0] + 2
        return with_response(through_learner, mixed_product, solved, constraint, evaluations=3, derivatives=passes)
