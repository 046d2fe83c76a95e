"""The paper's own model: one joint softmax policy for the sum of all rewards (eq. 5-7), and both levels under it.

    f(θ_l, θ_e) = E^π[Σ_t γ^t (r_ld + r_li)]        with the accessed values of r_ld
    L(θ_l, θ_e) = −E_D[Σ_t γ^t ln π(a_l, a_e|s, t)] + (λ/2)‖θ_e‖²

It is the model in which Lemmas 1 and 3 hold to the letter, for linear and for smooth nonlinear rewards.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.equilibria.soft_joint import SoftJoint, SoftJointSolution, joint_occupancy
from gsiirl.games.payoff import DensePayoff
from gsiirl.theory.support.direct import LemmaThree, LemmaThreeProblem, Tables
from gsiirl.theory.support.games import DISCOUNT, TEMPERATURE, RandomProblem
from gsiirl.types import Sides


class SoftJointModel(eqx.Module):
    """Eq. 5-7 on a random game, with r^θ(s, a) = (1 − κ) x + κ tanh x for x = θ·φ(s, a).

    κ = `curvature`: 0 is a linear reward, 1 a bounded one; for κ > 0 it is nonlinear and smooth. λ = `regularisation`.
    Demonstrations are given by their discounted occupancy γ^t P(s_t = s, a_t = a), (T, S, A_l, A_e).
    """

    instance: RandomProblem
    regularisation: float
    temperature: float | Float[Array, ""] = TEMPERATURE
    discount: float = DISCOUNT
    curvature: float | Float[Array, ""] = 0.0

    def dependent_reward(self, learner_parameters: Float[Array, " n"]) -> Float[Array, "S A_l A_e"]:
        """r_ld^θ_l."""
        return self._reward(self.instance.learner_features, learner_parameters)

    def expert_reward(self, expert_parameters: Float[Array, " m"]) -> Float[Array, "S A_l A_e"]:
        """r_e^θ_e."""
        return self._reward(self.instance.expert_features, expert_parameters)

    def solve(self, learner_parameters: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> SoftJointSolution:
        """π^{θ_l, θ_e}, the policy for r_ld^θ_l + r_li and r_e^θ_e."""
        return self._solve(learner_parameters, self.expert_reward(expert_parameters))

    def occupancy(
        self, learner_parameters: Float[Array, " n"], expert_parameters: Float[Array, " m"]
    ) -> Float[Array, "T S A_l A_e"]:
        """γ^t P(s_t = s, a_t = a) under π^{θ_l, θ_e}."""
        return self._occupancy(self.solve(learner_parameters, expert_parameters))

    def demonstrations(self, learner_parameters: Float[Array, " n"]) -> Float[Array, "T S A_l A_e"]:
        """The occupancy of infinitely many demonstrations D(θ_l): the joint policy for θ_l and the true r_e."""
        return self._occupancy(self.demonstrating_policy(learner_parameters))

    def demonstrating_policy(self, learner_parameters: Float[Array, " n"]) -> SoftJointSolution:
        """The joint policy for r_ld^θ_l + r_li and the true r_e."""
        return self._solve(learner_parameters, self.instance.true_expert_reward().dense())

    def objective(self, learner_parameters: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> Array:
        """f(θ_l, θ_e)."""
        return jnp.vdot(self.occupancy(learner_parameters, expert_parameters), self._returns_per_step())

    def learner_expectation(
        self, occupancy: Float[Array, "T S A_l A_e"], learner_parameters: Float[Array, " n"]
    ) -> Float[Array, " n"]:
        """μ_l = E[Σ_t γ^t ∇_{θ_l} r_ld^θ_l] over an occupancy."""
        return jnp.einsum("tsab,sabk->k", occupancy, jax.jacfwd(self.dependent_reward)(learner_parameters))

    def expert_expectation(
        self, occupancy: Float[Array, "T S A_l A_e"], expert_parameters: Float[Array, " m"]
    ) -> Float[Array, " m"]:
        """μ_e = E[Σ_t γ^t ∇_{θ_e} r_e^θ_e] over an occupancy."""
        return jnp.einsum("tsab,sabk->k", occupancy, jax.jacfwd(self.expert_reward)(expert_parameters))

    def lower_gradient(
        self,
        learner_parameters: Float[Array, " n"],
        expert_parameters: Float[Array, " m"],
        demonstrations: Float[Array, "T S A_l A_e"],
    ) -> Float[Array, " m"]:
        """Lemma 1: ∇_{θ_e} L = (μ_e(π) − μ̂_e(D)) / τ + λθ_e."""
        surplus = self.occupancy(learner_parameters, expert_parameters) - demonstrations
        return (
            self.expert_expectation(surplus, expert_parameters) / self.temperature
            + self.regularisation * expert_parameters
        )

    def upper_gradient(
        self,
        learner_parameters: Float[Array, " n"],
        expert_parameters: Float[Array, " m"],
        demonstrations: Float[Array, "T S A_l A_e"],
    ) -> Float[Array, " n"]:
        """∇_{θ_l} L = (μ_l(π) − μ̂_l(D)) / τ."""
        surplus = self.occupancy(learner_parameters, expert_parameters) - demonstrations
        return self.learner_expectation(surplus, learner_parameters) / self.temperature

    def tables(self, joint: Float[Array, "T S A_l A_e"], increments: Float[Array, "S A_l A_e k"]) -> Tables:
        """μ(s, a, t) = g(s, a) + γ E[μ(s', t + 1)] by one backward sweep, for k quantities g at once."""

        def backward(following, joint_now):
            onwards = jax.vmap(lambda values: self.instance.game.continuation(values).dense(), -1, -1)(following)
            from_action = increments + self.discount * onwards
            from_state = jnp.einsum("sab,sabk->sk", joint_now, from_action)
            return from_state, (from_action, from_state)

        nothing = jnp.zeros((increments.shape[0], increments.shape[-1]), increments.dtype)
        _, (from_action, from_state) = jax.lax.scan(backward, nothing, joint, reverse=True)
        return Tables(from_action, from_state)

    def lemma_three(
        self,
        learner_parameters: Float[Array, " n"],
        expert_parameters: Float[Array, " m"],
        demonstrations: Float[Array, "T S A_l A_e"],
    ) -> LemmaThree:
        """The terms of Lemma 3, in O(T) sweeps."""
        joint = self.solve(learner_parameters, expert_parameters).joint
        weights = joint_occupancy(self.instance.game, joint, self.discount)
        learner = self.tables(joint, jax.jacfwd(self.dependent_reward)(learner_parameters))
        expert = self.tables(joint, jax.jacfwd(self.expert_reward)(expert_parameters))
        reward = (self.instance.accessed + self.instance.own_reward)[..., None]
        surplus = jnp.sum(weights - demonstrations, axis=0)
        return LemmaThree(
            weights=weights,
            learner=learner,
            expert=expert,
            returns=self.tables(joint, reward).from_action[..., 0],
            expert_curvature=jax.hessian(lambda theta: jnp.vdot(surplus, self.expert_reward(theta)))(expert_parameters),
            temperature=self.temperature,
        )

    def problem(
        self, learner_parameters: Float[Array, " n"], expert_parameters: Float[Array, " m"]
    ) -> LemmaThreeProblem:
        """The bilevel problem at (θ_l, θ_e), with the demonstrations D(θ_l) held and their own change measured exactly.

        ∇_{θ_e} r_e, and with it μ̂_e(D), depends on θ_e where the reward is not linear.
        """
        demonstrations = self.demonstrations(learner_parameters)

        def evaluate(learner: Array, expert: Array) -> tuple[Array, Array]:
            occupancy = self.occupancy(learner, expert)
            surplus = self.expert_expectation(occupancy - demonstrations, expert)
            return jnp.vdot(occupancy, self._returns_per_step()), surplus / self.temperature

        moved = jax.jacfwd(lambda theta: self.expert_expectation(self.demonstrations(theta), expert_parameters))
        return LemmaThreeProblem(
            evaluate=evaluate,
            regularisation=self.regularisation,
            upper_gradient=lambda learner, expert: self.upper_gradient(learner, expert, demonstrations),
            demonstration_jacobian=moved(learner_parameters) / self.temperature,
            lemma_three=lambda learner, expert: self.lemma_three(learner, expert, demonstrations),
        )

    def _reward(self, features: Array, parameters: Array) -> Array:
        linear = features @ parameters
        return (1.0 - self.curvature) * linear + self.curvature * jnp.tanh(linear)

    def _solve(self, learner_parameters: Array, expert_reward: Array) -> SoftJointSolution:
        learner_reward = self.dependent_reward(learner_parameters) + self.instance.own_reward
        rewards = Sides(DensePayoff(learner_reward), DensePayoff(expert_reward))
        return SoftJoint(self.temperature).solve(self.instance.game, rewards, self.discount)

    def _occupancy(self, solution: SoftJointSolution) -> Array:
        return joint_occupancy(self.instance.game, solution.joint, self.discount)

    def _returns_per_step(self) -> Float[Array, "T S A_l A_e"]:
        reward = self.instance.accessed + self.instance.own_reward
        return jnp.broadcast_to(reward[None], (self.instance.game.horizon, *reward.shape))
