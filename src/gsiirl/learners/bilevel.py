"""Problems (1) and (2) of the paper for one game, with what the learner knows: both levels as functions of θ_l, θ_e.

Upper level:  f(θ_l, θ_e) = E^π[Σ_t γ^t (r_ld + r_li)] with the accessed values of r_ld, π = forward model at
(r^θ_l + r_li, r^θ_e).

Lower level:  G(θ_l, θ_e) = ∇_{θ_e} L = (μ_e(π') − μ̂_e(D))/τ + λθ_e, with π' by `lower_level`

* `played`: π_l as it was played, that is by the forward model at (θ_l, θ̄_e) for the θ̄_e then believed, and
  respond(π_l, r^θ_e). G is the gradient of L = (E_{s_0} V_e,0(s_0; π_l, θ_e) − θ_e·μ̂_e)/τ + (λ/2)‖θ_e‖².
* `equilibrium` (the paper's line 6): the forward model at (θ_l, θ_e). Feature matching: no L has this gradient.
"""

from typing import Literal

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.equilibria.base import AbstractForwardModel, AbstractSolution
from gsiirl.equilibria.response import respond
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.hypergradients.problem import BilevelProblem
from gsiirl.irl.expectations import expected_return, reward_gradient_expectation
from gsiirl.irl.likelihood import played_gradient
from gsiirl.irl.memory import Memory, Played
from gsiirl.rewards.linear import Linear
from gsiirl.types import Number, Sides

LowerLevel = Literal["played", "equilibrium"]


class Bilevel(eqx.Module):
    """Both levels of one game.

    `own_reward` is r_li; `accessed` the values of r_ld; `dependent_reward`, `expert_reward` the parametric r_ld^θ_l and
    r_e^θ_e. The first two are payoffs over (S, A_l, A_e), such as `games.DensePayoff(array)`, in reward units;
    `temperature` is the expert's τ > 0 in the same units, `discount` γ in (0, 1], `regularisation` λ.
    None of them is checked.
    """

    game: AbstractTabularGame
    own_reward: AbstractPayoff
    accessed: AbstractPayoff
    dependent_reward: Linear
    expert_reward: Linear
    forward_model: AbstractForwardModel
    temperature: float
    discount: float
    regularisation: Number = 1e-3
    lower_level: LowerLevel = eqx.field(static=True, default="played")

    def committed_reward(self, commitment: Float[Array, " n"]) -> AbstractPayoff:
        """r^θ_l + r_li, the reward that the learner acts on."""
        return self.dependent_reward.payoff(commitment) + self.own_reward

    def solve(self, commitment: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> AbstractSolution:
        """The forward model at (θ_l, θ_e)."""
        rewards = Sides(self.committed_reward(commitment), self.expert_reward.payoff(expert_parameters))
        return self.forward_model.solve(self.game, rewards, self.discount)

    def objective(self, commitment: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> Float[Array, ""]:
        """f(θ_l, θ_e), the learner's discounted return under the accessed values (problem (2)); it is maximised."""
        return self._objective_of(self.solve(commitment, expert_parameters))

    def lower_gradient(
        self, commitment: Float[Array, " n"], expert_parameters: Float[Array, " m"], memory: Memory[Played]
    ) -> Float[Array, " m"]:
        """G averaged over the remembered interactions, (m,); what was played in each of them is remembered too."""
        if self.lower_level == "equilibrium":
            modelled = self._feature_expectation(self.solve(commitment, expert_parameters))
            demonstrated = jnp.mean(memory.kept.demonstrated, axis=0, where=memory.filled[:, None])
            return (modelled - demonstrated) / self.temperature + self.regularisation * expert_parameters
        gradients = jax.vmap(lambda policy, seen: self._played_gradient(policy, expert_parameters, seen))(
            memory.kept.learner_policy, memory.kept.demonstrated
        )
        return jnp.mean(gradients, axis=0, where=memory.filled[:, None]) + self.regularisation * expert_parameters

    def problem(
        self,
        believed: Float[Array, " m"],
        demonstrated: Float[Array, " m"],
        demonstration_jacobian: Float[Array, "m n"] | None = None,
    ) -> BilevelProblem:
        """The bilevel problem for demonstrations with μ̂_e(D) = `demonstrated`, collected while θ̄_e was believed.

        `demonstration_jacobian` is dμ̂_e(D(θ_l))/dθ_l, where it was measured.
        """

        def evaluate(commitment: Array, expert_parameters: Array) -> tuple[Array, Array]:
            solution = self.solve(commitment, expert_parameters)
            objective = self._objective_of(solution)
            if self.lower_level == "equilibrium":
                return objective, (self._feature_expectation(solution) - demonstrated) / self.temperature
            return objective, self._played_gradient(
                self.solve(commitment, believed).policies.learner, expert_parameters, demonstrated
            )

        def upper_gradient(commitment: Array, expert_parameters: Array) -> Array:
            # L's data term does not depend on θ_l but through D, which is held.
            return jax.grad(lambda theta: self._soft_value(theta, believed, expert_parameters))(commitment)

        return BilevelProblem(
            evaluate=evaluate,
            regularisation=self.regularisation,
            upper_gradient=upper_gradient if self.lower_level == "played" else None,
            demonstration_jacobian=None
            if demonstration_jacobian is None
            else demonstration_jacobian / self.temperature,
        )

    def _objective_of(self, solution: AbstractSolution) -> Float[Array, ""]:
        return expected_return(self.game, self.accessed + self.own_reward, solution.policies, self.discount)

    def _feature_expectation(self, solution: AbstractSolution) -> Float[Array, " m"]:
        return reward_gradient_expectation(self.game, self.expert_reward, solution.policies, self.discount)

    def _played_gradient(self, learner_policy: Array, expert_parameters: Array, demonstrated: Array) -> Array:
        return played_gradient(
            self.game,
            self.expert_reward,
            expert_parameters,
            learner_policy,
            demonstrated,
            self.temperature,
            self.discount,
        )

    def _soft_value(self, commitment: Array, believed: Array, expert_parameters: Array) -> Array:
        """E_{s_0} V_e,0(s_0; π_l(θ_l), θ_e) / τ."""
        played = self.solve(commitment, believed).policies.learner
        reward = self.expert_reward.payoff(expert_parameters)
        values = respond(self.game, played, reward, self.temperature, self.discount).values
        return jnp.vdot(self.game.initial, values[0]) / self.temperature
