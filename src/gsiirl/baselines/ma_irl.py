"""MA-IRL: both rewards fitted to one fixed set of demonstrations of the true game (spec section 7).

Per iteration, under the same forward model and in the same reward classes as GSIIRL,

    θ_i ← Proj(θ_i − step of ((μ_i(π^θ) − μ̂_i(D*)) + τ λ θ_i))       for both sides i

The paper names Lin et al. 2019, but that is a one-shot program on known policies and cannot give its per-iteration curves.
"""

import equinox as eqx
import jax
import optax
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.equilibria.logit import Logit, LogitSolution
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.irl.expectations import reward_gradient_expectation, sampled_reward_gradient
from gsiirl.rewards.linear import Linear
from gsiirl.types import Sides, Trajectories


class MAIRLState(eqx.Module):
    """Parameters of both sides' rewards, and the feature expectations μ̂_i(D*) they are fitted to."""

    parameters: Sides[Float[Array, "..."]]
    demonstrated: Sides[Float[Array, "..."]]
    optimiser: optax.OptState


class MAIRL(eqx.Module):
    """Two-sided feature matching on fixed demonstrations D* of the true game; it never interacts.

    `own_reward` is r_li, known; `rewards` are the parametric r_ld^θ_l and r_e^θ_e; λ = `regularisation`; `optimiser` makes
    `steps` matching steps an iteration.
    """

    game: AbstractTabularGame
    own_reward: AbstractPayoff
    rewards: Sides[Linear]
    forward_model: Logit
    discount: float
    regularisation: float
    steps: int = eqx.field(static=True)
    optimiser: optax.GradientTransformation = eqx.field(static=True)

    def init(self, key: PRNGKeyArray, demonstrations: Trajectories) -> MAIRLState:
        """Random parameters in the unit ball, and what the demonstrations say."""
        dtype = self.game.initial.dtype
        learner_key, expert_key = jax.random.split(key)
        parameters = Sides(
            self.rewards.learner.initial_parameters(learner_key, dtype),
            self.rewards.expert.initial_parameters(expert_key, dtype),
        )
        return MAIRLState(
            parameters=parameters,
            optimiser=self.optimiser.init(parameters),
            demonstrated=Sides(
                sampled_reward_gradient(self.rewards.learner, demonstrations, self.discount, dtype),
                sampled_reward_gradient(self.rewards.expert, demonstrations, self.discount, dtype),
            ),
        )

    def propose(self, state: MAIRLState) -> LogitSolution:
        """The forward model at the current parameters."""
        return self._forward(state.parameters)

    def update(self, state: MAIRLState) -> MAIRLState:
        """One iteration: `steps` projected feature-matching steps for both sides together."""

        def one_step(_: int, carry: tuple[Sides, optax.OptState]) -> tuple[Sides, optax.OptState]:
            parameters, optimiser = carry
            policies = self._forward(parameters).policies

            def gradient(reward: Linear, theta: Array, demonstrated: Array) -> Array:
                gap = reward_gradient_expectation(self.game, reward, policies, self.discount) - demonstrated
                return gap + self.forward_model.temperature * self.regularisation * theta

            gradients = Sides(
                gradient(self.rewards.learner, parameters.learner, state.demonstrated.learner),
                gradient(self.rewards.expert, parameters.expert, state.demonstrated.expert),
            )
            step, optimiser = self.optimiser.update(gradients, optimiser, parameters)
            moved = optax.apply_updates(parameters, step)
            return Sides(
                optax.projections.projection_l2_ball(moved.learner, 1.0),
                optax.projections.projection_l2_ball(moved.expert, 1.0),
            ), optimiser

        parameters, optimiser = jax.lax.fori_loop(0, self.steps, one_step, (state.parameters, state.optimiser))
        return MAIRLState(parameters, state.demonstrated, optimiser)

    def _forward(self, parameters: Sides) -> LogitSolution:
        rewards = Sides(
            self.rewards.learner.payoff(parameters.learner) + self.own_reward,
            self.rewards.expert.payoff(parameters.expert),
        )
        return self.forward_model.solve(self.game, rewards, self.discount)
