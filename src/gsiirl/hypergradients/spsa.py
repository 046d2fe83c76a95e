"""Simultaneous perturbation (Spall 1992, 2000), as the paper estimates every factor, mended where it cannot run.

The paper's eq. 4 draws one Δ for both spaces and hands (1/Δ)(δG)ᵀ/2p, of rank one and not symmetric, to conjugate
gradients. Here (docs/deviations.md): Rademacher Δ_l and Δ_e are independent; the two sides of a difference share their
random numbers; only the likelihood part of H is estimated, made symmetric, averaged over draws and over iterations,
its eigenvalues floored at zero, and λI added exactly.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PRNGKeyArray

from gsiirl.hypergradients.compose import with_response, without_response
from gsiirl.hypergradients.linear_solve import BallConstraint, conjugate_gradients
from gsiirl.hypergradients.problem import AbstractEstimator, BilevelProblem, Hypergradient, ResponseKind


class SPSAState(eqx.Module):
    """The running average of H's likelihood part over `count` iterations."""

    hessian: Float[Array, "m m"]
    count: Int[Array, ""]


class Factors(eqx.Module):
    """Estimates of ∇_{θ_l} f, ∇_{θ_e} f, H (likelihood part, symmetric) and M, one a draw along the leading axis."""

    learner_gradient: Float[Array, "draws n"]
    expert_gradient: Float[Array, "draws m"]
    hessian: Float[Array, "draws m m"]
    mixed: Float[Array, "draws m n"]
    lower_gradient: Float[Array, " m"]


class SPSA(AbstractEstimator[SPSAState]):
    """∇f from 4 evaluations a draw (2 for `well_specified`), and one more; all of them one vmapped call.

    The perturbation is p_k = `perturbation` / (k + 1)^`decay`: 0.101 is Spall's; the paper's 1/k is 1 and 1.
    """

    response: ResponseKind = eqx.field(static=True, default="well_specified")
    perturbation: float = 0.05
    decay: float = 0.101
    draws: int = eqx.field(static=True, default=1)

    def init(self, expert_parameters: Float[Array, " m"]) -> SPSAState:
        size = expert_parameters.shape[0]
        return SPSAState(jnp.zeros((size, size), expert_parameters.dtype), jnp.zeros((), jnp.int32))

    def estimate(
        self,
        problem: BilevelProblem,
        learner_parameters: Float[Array, " n"],
        expert_parameters: Float[Array, " m"],
        state: SPSAState,
        key: PRNGKeyArray,
        iteration: Int[Array, ""],
    ) -> tuple[Hypergradient, SPSAState]:
        dtype = learner_parameters.dtype
        reach = self.perturbation / (iteration.astype(dtype) + 1.0) ** self.decay
        if self.response == "well_specified":
            directions = jax.random.rademacher(key, (self.draws, learner_parameters.shape[0]), dtype)
            points = learner_parameters[None, :] + reach * jnp.concatenate([directions, -directions])
            values = jax.vmap(lambda theta: problem.objective(theta, expert_parameters))(points)
            slopes = (values[: self.draws] - values[self.draws :]) / (2.0 * reach)
            gradient = jnp.mean(slopes[:, None] * directions, axis=0)
            return without_response(gradient, evaluations=2 * self.draws), state
        moved = problem.demonstrations_move(self.response)
        drawn = self.factors(problem, learner_parameters, expert_parameters, key, reach)
        weight = 1.0 / (state.count.astype(dtype) + 1.0)
        averaged = state.hessian + weight * (jnp.mean(drawn.hessian, axis=0) - state.hessian)
        hessian = at_least(averaged, 0.0) + problem.regularisation * jnp.eye(averaged.shape[0], dtype=dtype)
        constraint = BallConstraint.at(expert_parameters, drawn.lower_gradient)
        solved = conjugate_gradients(
            lambda direction: hessian @ direction,
            jnp.mean(drawn.expert_gradient, axis=0),
            constraint,
            tolerance=1e-10,
            iterations=2 * averaged.shape[0],
        )
        # Δ_l alone makes M, Δ_e alone H and ∇_{θ_e} f: the factors of the product are independent.
        mixed_product = (jnp.mean(drawn.mixed, axis=0) + moved).T @ solved.solution
        estimate = with_response(
            jnp.mean(drawn.learner_gradient, axis=0),
            mixed_product,
            solved,
            constraint,
            evaluations=4 * self.draws + 1,
        )
        return estimate, SPSAState(averaged, state.count + 1)

    def factors(
        self,
        problem: BilevelProblem,
        learner_parameters: Float[Array, " n"],
        expert_parameters: Float[Array, " m"],
        key: PRNGKeyArray,
        reach: Float[Array, ""],
    ) -> Factors:
        """Every factor of ∇f at perturbation p = `reach`, draw by draw; M without what the demonstrations add."""
        learner_key, expert_key = jax.random.split(key)
        dtype, draws = learner_parameters.dtype, self.draws
        learner_moves = jax.random.rademacher(learner_key, (draws, learner_parameters.shape[0]), dtype)
        expert_moves = jax.random.rademacher(expert_key, (draws, expert_parameters.shape[0]), dtype)
        learner_offsets = reach * jnp.concatenate(
            [learner_moves, -learner_moves, jnp.zeros((2 * draws + 1, learner_parameters.shape[0]), dtype)]
        )
        expert_offsets = reach * jnp.concatenate(
            [
                jnp.zeros((2 * draws, expert_parameters.shape[0]), dtype),
                expert_moves,
                -expert_moves,
                jnp.zeros((1, expert_parameters.shape[0]), dtype),
            ]
        )
        objectives, gradients = jax.vmap(problem.evaluate)(
            learner_parameters[None, :] + learner_offsets, expert_parameters[None, :] + expert_offsets
        )

        def slope(values: Array, first: int) -> Array:
            return (values[first : first + draws] - values[first + draws : first + 2 * draws]) / (2.0 * reach)

        # A Rademacher variable is its own inverse.
        hessian = jnp.einsum("di,dj->dij", slope(gradients, 2 * draws), expert_moves)
        return Factors(
            learner_gradient=slope(objectives, 0)[:, None] * learner_moves,
            expert_gradient=slope(objectives, 2 * draws)[:, None] * expert_moves,
            hessian=0.5 * (hessian + jnp.swapaxes(hessian, 1, 2)),
            mixed=jnp.einsum("di,dj->dij", slope(gradients, 0), learner_moves),
            lower_gradient=gradients[-1] + problem.regularisation * expert_parameters,
        )


def directional_jacobian(directions: Float[Array, "draws n"], slopes: Float[Array, "draws m"]) -> Float[Array, "m n"]:
    """A Jacobian from slopes along Rademacher directions, averaged over draws; unbiased up to O(p²)."""
    return jnp.mean(jnp.einsum("dm,dn->dmn", slopes, directions), axis=0)


def at_least(matrix: Float[Array, "m m"], floor: float) -> Float[Array, "m m"]:
    """A symmetric matrix with its eigenvalues raised to `floor`."""
    values, vectors = jnp.linalg.eigh(matrix)
    return (vectors * jnp.maximum(values, floor)[None, :]) @ vectors.T
