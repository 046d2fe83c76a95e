"""The bilevel problem as estimators see it, and what they give back (docs/theory.md, Lemma 2).

    max_{θ_l} f(θ_l, θ_e*(θ_l)),     θ_e*(θ_l) = argmin_{‖θ_e‖ ≤ 1} L(θ_l, θ_e)

    ∇f = ∇_{θ_l} f + (dθ_e*/dθ_l)ᵀ ∇_{θ_e} f,     dθ_e*/dθ_l = −H⁻¹ M     (inside the ball)

With G(θ_l, θ_e) = ∇_{θ_e} L ∈ R^m:  H = dG/dθ_e ∈ R^{m×m},  M = dG/dθ_l ∈ R^{m×n}.
"""

import abc
from collections.abc import Callable
from typing import Generic, Literal, TypeVar

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from gsiirl.hypergradients.vectors import ExpertVector, LearnerVector

State = TypeVar("State")

ResponseKind = Literal["well_specified", "frozen", "measured"]
"""What is taken for dθ_e*/dθ_l.

`well_specified`: nothing, because a reward class that can express r_e keeps finding the same θ_e (up to O(λ));
`frozen`: the paper's, which holds the demonstrations D fixed although they are collected under θ_l;
`measured`: all of it, with dD/dθ_l from further interactions.
"""


class BilevelProblem(eqx.Module):
    """The bilevel problem at one moment: the demonstrations are those collected under the current θ_l.

    `evaluate(θ_l, θ_e)` is (f, G − λθ_e): the objective, and the gradient of L's likelihood part (m,).
    `upper_gradient(θ_l, θ_e)` is ∇_{θ_l} L (n,); None where G is the gradient of no L, and H need not be symmetric.
    `demonstration_jacobian` (m, n) is what the demonstrations' own change subtracts from M,
    (1/τ) dμ̂_e(D(θ_l))/dθ_l; only `measured` asks for it.
    λ = `regularisation`.
    """

    evaluate: Callable[[Array, Array], tuple[Array, Array]]
    regularisation: float | Float[Array, ""]
    upper_gradient: Callable[[Array, Array], Array] | None = None
    demonstration_jacobian: Float[Array, "m n"] | None = None

    def objective(self, learner_parameters: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> Array:
        """f(θ_l, θ_e)."""
        return self.evaluate(learner_parameters, expert_parameters)[0]

    def lower_gradient(self, learner_parameters: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> Array:
        """G(θ_l, θ_e) = ∇_{θ_e} L, the regularisation included."""
        return self.evaluate(learner_parameters, expert_parameters)[1] + self.regularisation * expert_parameters

    def demonstrations_move(self, response: ResponseKind) -> Array | float:
        """dG/dθ_l through the demonstrations, (m, n), as far as `response` takes it into account.

        Raises:
            ValueError: `measured`, and nothing was measured.
        """
        if response == "frozen":
            return 0.0
        if self.demonstration_jacobian is None:
            raise ValueError("response 'measured' needs demonstration_jacobian: demonstrations at other θ_l")
        return -self.demonstration_jacobian


class Hypergradient(eqx.Module):
    """An estimate of ∇f with its parts and its diagnostics.

    `value` = `through_learner` + `through_expert`: ∇_{θ_l} f and (dθ_e*/dθ_l)ᵀ ∇_{θ_e} f. `evaluations` counts calls of
    `evaluate`, `derivatives` passes of automatic differentiation through it, `upper_evaluations` calls of
    `upper_gradient`. `linear_residual` is that of the system with H, relative; `smallest_eigenvalue` the smallest one
    met of H's symmetric part (on the sphere, of the tangential system); `constrained` says that the ball is active.
    Where no system was solved they are 0, ∞ and False.
    """

    value: Float[Array, " n"]
    through_learner: Float[Array, " n"]
    through_expert: Float[Array, " n"]
    evaluations: Int[Array, ""]
    derivatives: Int[Array, ""]
    upper_evaluations: Int[Array, ""]
    linear_residual: Float[Array, ""]
    smallest_eigenvalue: Float[Array, ""]
    constrained: Bool[Array, ""]

    @property
    def calls(self) -> Int[Array, ""]:
        """Calls and passes together."""
        return self.evaluations + self.derivatives + self.upper_evaluations


class AbstractEstimator(eqx.Module, Generic[State]):
    """A way to estimate ∇f; what it remembers from one outer iteration to the next is a state passed in and out."""

    response: eqx.AbstractVar[ResponseKind]

    @abc.abstractmethod
    def init(self, expert_parameters: Float[Array, " m"]) -> State:
        """What is remembered before the first estimate."""

    @abc.abstractmethod
    def estimate(
        self,
        problem: BilevelProblem,
        learner_parameters: Float[Array, " n"],
        expert_parameters: Float[Array, " m"],
        state: State,
        key: PRNGKeyArray,
        iteration: Int[Array, ""],
    ) -> tuple[Hypergradient, State]:
        """∇f at (θ_l, θ_e) in outer iteration k ≥ 0."""


class AbstractStatelessEstimator(AbstractEstimator[None]):
    """An estimator that remembers nothing and draws nothing: `hypergradient` is all there is to it."""

    @abc.abstractmethod
    def hypergradient(self, problem: BilevelProblem, learner: LearnerVector, expert: ExpertVector) -> Hypergradient:
        """∇f at (θ_l, θ_e)."""

    def init(self, expert_parameters: Float[Array, " m"]) -> None:
        return None

    def estimate(
        self,
        problem: BilevelProblem,
        learner_parameters: Float[Array, " n"],
        expert_parameters: Float[Array, " m"],
        state: None,
        key: PRNGKeyArray,
        iteration: Int[Array, ""],
    ) -> tuple[Hypergradient, None]:
        return self.hypergradient(problem, learner_parameters, expert_parameters), None
