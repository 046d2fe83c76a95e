"""Conjugate gradients whose products are differences of gradients along one direction: no Hessian is formed."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array

from gsiirl.hypergradients.compose import with_response, without_response
from gsiirl.hypergradients.linear_solve import BallConstraint, conjugate_gradients
from gsiirl.hypergradients.problem import AbstractStatelessEstimator, BilevelProblem, Hypergradient, ResponseKind
from gsiirl.hypergradients.vectors import ExpertVector, LearnerVector


class HessianVectorCG(AbstractStatelessEstimator):
    """∇f with Hv ≈ [G(θ_e + εv) − G(θ_e − εv)] / 2ε and Mᵀw ≈ [∇_{θ_l}L(θ_e + εw) − ∇_{θ_l}L(θ_e − εw)] / 2ε.

    ε is `step` over the direction's norm; the error is O(ε²). ∇f's own parts come from one backward pass. Two
    evaluations an iteration of conjugate gradients; needs a lower level that is the gradient of some L.
    """

    response: ResponseKind = eqx.field(static=True, default="well_specified")
    step: float = 1e-4
    tolerance: float = 1e-10
    iterations: int = eqx.field(static=True, default=100)

    def hypergradient(self, problem: BilevelProblem, learner: LearnerVector, expert: ExpertVector) -> Hypergradient:
        """∇f at (θ_l, θ_e).

        Raises:
            ValueError: the problem has no `upper_gradient`: H need not be symmetric there, and `Implicit` or
                `FiniteDifference` serve.
        """
        if self.response == "well_specified":
            gradient = jax.grad(problem.objective)(learner, expert)
            return without_response(gradient, evaluations=1, derivatives=1)
        upper_gradient = problem.upper_gradient
        if upper_gradient is None:
            raise ValueError("conjugate gradients need a lower level that is the gradient of some L: upper_gradient")
        moved = problem.demonstrations_move(self.response)
        through_learner, through_expert = jax.grad(problem.objective, (0, 1))(learner, expert)
        constraint = BallConstraint.at(expert, problem.lower_gradient(learner, expert))

        def along(gradient, direction: Array) -> Array:
            """The derivative of a gradient along `direction` in θ_e."""
            size = jnp.linalg.norm(direction)
            reach = self.step / jnp.where(size > 0.0, size, 1.0)
            points = expert[None, :] + reach * jnp.stack([direction, -direction])
            forth, back = jax.vmap(lambda theta: gradient(learner, theta))(points)
            return (forth - back) / (2.0 * reach)

        solved = conjugate_gradients(
            lambda direction: along(problem.lower_gradient, direction),
            through_expert,
            constraint,
            self.tolerance,
            self.iterations,
        )
        mixed_product = along(upper_gradient, solved.solution)
        if self.response == "measured":
            mixed_product = mixed_product + jnp.dot(solved.solution, moved)
        return with_response(
            through_learner,
            mixed_product,
            solved,
            constraint,
            evaluations=2 + 2 * solved.products,
            derivatives=1,
            upper_evaluations=2,
        )
