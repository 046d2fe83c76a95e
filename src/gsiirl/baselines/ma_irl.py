"""MA-IRL: both rewards fitted to one fixed set of demonstrations of the true game.

Per iteration, under the same forward model and in the same reward classes as GSIIRL,

    θ_i ← Proj(θ_i − step of ((μ_i(π^θ) − μ̂_i(D*)) + τ λ θ_i))       for both sides i

The paper names Lin et al. 2019, but that is a one-shot program on known policies and cannot give its per-iteration
curves.
"""

from collections.abc import Callable

import equinox as eqx
import jax
import optax
from jaxtyping import Array, Float, PRNGKeyArray, PyTree

from gsiirl.equilibria.base import AbstractForwardModel, AbstractSolution
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

    `own_reward` is r_li, known; `rewards` are the parametric r_ld^θ_l and r_e^θ_e; τ = `temperature`,
    λ = `regularisation`; `optimiser` makes `steps` matching steps an iteration.
    """

    game: AbstractTabularGame
    own_reward: AbstractPayoff
    rewards: Sides[Linear]
    forward_model: AbstractForwardModel
    temperature: float
    discount: float
    regularisation: float
    steps: int = eqx.field(static=True)
    optimiser: optax.GradientTransformation = eqx.field(static=True)

    def init(self, key: PRNGKeyArray, demonstrations: Trajectories) -> MAIRLState:
        """Random parameters in the unit ball, and what the demonstrations say."""
        dtype = self.game.initial.dtype
        keys = Sides(*jax.random.split(key))
        parameters = self._of_each(lambda reward, one: reward.initial_parameters(one, dtype), keys)
        demonstrated = self._of_each(
            lambda reward: sampled_reward_gradient(reward, demonstrations, self.discount, dtype)
        )
        return MAIRLState(parameters, demonstrated, self.optimiser.init(parameters))

    def propose(self, state: MAIRLState) -> AbstractSolution:
        """The forward model at the current parameters."""
        return self._forward(state.parameters)

    def update(self, state: MAIRLState) -> MAIRLState:
        """One iteration: `steps` projected feature-matching steps for both sides together."""

        def one_step(_: Array, carry: tuple[PyTree, optax.OptState]) -> tuple[PyTree, optax.OptState]:
            parameters, optimiser = carry
            policies = self._forward(parameters).policies

            def gradient(reward: Linear, theta: Array, demonstrated: Array) -> Array:
                gap = reward_gradient_expectation(self.game, reward, policies, self.discount) - demonstrated
                return gap + self.temperature * self.regularisation * theta

            gradients = self._of_each(gradient, parameters, state.demonstrated)
            step, optimiser = self.optimiser.update(gradients, optimiser, parameters)
            moved = optax.apply_updates(parameters, step)
            # Each side's parameters have a unit ball of their own.
            return jax.tree.map(lambda theta: optax.projections.projection_l2_ball(theta, 1.0), moved), optimiser

        parameters, optimiser = jax.lax.fori_loop(0, self.steps, one_step, (state.parameters, state.optimiser))
        return MAIRLState(parameters, state.demonstrated, optimiser)

    def _of_each(self, function: Callable[..., Array], *values: PyTree) -> PyTree:
        """`function` of each side's reward and values."""
        return jax.tree.map(function, self.rewards, *values, is_leaf=lambda node: isinstance(node, Linear))

    def _forward(self, parameters: Sides) -> AbstractSolution:
        rewards = Sides(
            self.rewards.learner.payoff(parameters.learner) + self.own_reward,
            self.rewards.expert.payoff(parameters.expert),
        )
        return self.forward_model.solve(self.game, rewards, self.discount)
