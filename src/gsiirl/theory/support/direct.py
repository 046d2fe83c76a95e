"""The formulas of Lemma 3, corrected: every factor of ∇f as an expectation under the joint policy.

With ∇_{θ_i} ln π(a|s) = (μ_i(s, a) − μ_i(s)) / τ for the joint softmax policy of the paper's eq. 5-7, μ_i(s, a) the
discounted reward gradients from (s, a) on and J(s, a) the learner's accessed return from there:

    ∇_{θ_i} f      = (1/τ) E^π[Σ_t γ^t (μ_i(s, a) − μ_i(s)) J(s, a)]
    M = ∇²_{θ_e θ_l} L = (1/τ²) E^π[Σ_t γ^t μ_e(s, a) (μ_l(s, a) − μ_l(s))ᵀ]
    H = ∇²_{θ_e} L = (1/τ²) E^π[Σ_t γ^t (μ_e(s, a) − μ_e(s)) μ_e(s, a)ᵀ] + (E^π − E_D)[Σ_t γ^t ∇² r_e] / τ + λI

What the paper prints instead is listed in docs/theory.md.
"""

from collections.abc import Callable

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.hypergradients.compose import with_response, without_response
from gsiirl.hypergradients.linear_solve import BallConstraint, solve_dense
from gsiirl.hypergradients.problem import AbstractStatelessEstimator, BilevelProblem, Hypergradient, ResponseKind
from gsiirl.hypergradients.vectors import ExpertVector, LearnerVector


class Tables(eqx.Module):
    """Discounted sums from (s, a) at t on, and their means μ(s, t) = Σ_a π(a|s, t) μ(s, a, t)."""

    from_action: Float[Array, "T S A_l A_e k"]
    from_state: Float[Array, "T S k"]

    @property
    def advantages(self) -> Float[Array, "T S A_l A_e k"]:
        """μ(s, a, t) − μ(s, t)."""
        return self.from_action - self.from_state[:, :, None, None, :]


class LemmaThree(eqx.Module):
    """What Lemma 3 takes expectations of.

    `weights` γ^t P(s_t = s, a_t = a); `learner`, `expert` μ_i(s, a) and μ_i(s); `returns` J(s, a); `expert_curvature`
    (E^π − E_D)[Σ_t γ^t ∇² r_e], zero for linear rewards.
    """

    weights: Float[Array, "T S A_l A_e"]
    learner: Tables
    expert: Tables
    returns: Float[Array, "T S A_l A_e"]
    expert_curvature: Float[Array, "m m"]
    temperature: float | Float[Array, ""]

    def objective_gradients(self) -> tuple[Float[Array, " n"], Float[Array, " m"]]:
        """∇_{θ_l} f and ∇_{θ_e} f."""
        weighted = self.weights * self.returns / self.temperature
        return (
            jnp.einsum("tsab,tsabk->k", weighted, self.learner.advantages),
            jnp.einsum("tsab,tsabk->k", weighted, self.expert.advantages),
        )

    def mixed(self) -> Float[Array, "m n"]:
        """M, the demonstrations held fixed."""
        weighted = self.weights[..., None] * self.learner.advantages
        return jnp.einsum("tsabm,tsabn->mn", self.expert.from_action, weighted) / self.temperature**2

    def hessian(self) -> Float[Array, "m m"]:
        """H without λI."""
        weighted = self.weights[..., None] * self.expert.advantages
        likelihood = jnp.einsum("tsabm,tsabk->mk", weighted, self.expert.from_action) / self.temperature**2
        return likelihood + self.expert_curvature / self.temperature


class LemmaThreeProblem(BilevelProblem):
    """A bilevel problem of the joint softmax policy; `lemma_three(θ_l, θ_e)` gives the terms of Lemma 3."""

    lemma_three: Callable[[Array, Array], LemmaThree] = eqx.field(kw_only=True)


class Direct(AbstractStatelessEstimator):
    """∇f by the corrected Lemma 3; for the joint softmax policy alone."""

    response: ResponseKind = eqx.field(static=True, default="well_specified")

    def hypergradient(self, problem: BilevelProblem, learner: LearnerVector, expert: ExpertVector) -> Hypergradient:
        """∇f at (θ_l, θ_e).

        Raises:
            ValueError: the problem is not a `LemmaThreeProblem`.
        """
        if not isinstance(problem, LemmaThreeProblem):
            raise ValueError("Lemma 3 holds for the joint softmax policy only: give a LemmaThreeProblem")
        terms = problem.lemma_three(learner, expert)
        through_learner, through_expert = terms.objective_gradients()
        if self.response == "well_specified":
            return without_response(through_learner, evaluations=1)
        moved = problem.demonstrations_move(self.response)
        size, dtype = expert.shape[0], expert.dtype
        hessian = terms.hessian() + problem.regularisation * jnp.eye(size, dtype=dtype)
        constraint = BallConstraint.at(expert, problem.lower_gradient(learner, expert))
        solved = solve_dense(hessian.T, through_expert, constraint)
        mixed_product = (terms.mixed() + moved).T @ solved.solution
        return with_response(through_learner, mixed_product, solved, constraint, evaluations=2)
