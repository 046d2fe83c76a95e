"""MA-IRL in continuous games: both rewards fitted to demonstrations of the true game, without interacting.

Per iteration, under the same forward model and in the same reward classes as GSIIRL,

    θ_i ← Proj(θ_i − step of ((μ_i(π^θ) − μ̂_i(D*))/scale + λθ_i))       for both sides i

with both expectations from the initial states of the same share of D*.
"""

from typing import Any

import equinox as eqx
import jax
import optax
from jaxtyping import Array, PRNGKeyArray

from gsiirl.equilibria.pathwise import Ascent, Pathwise, policies_of
from gsiirl.games.rollout import episodes_from
from gsiirl.irl.feature_gap import first_states, reward_gap
from gsiirl.irl.maximum_likelihood import across
from gsiirl.rewards.continuous import AbstractTransitionReward, TransitionReward
from gsiirl.types import Sides, Transition


class ContinuousMAIRLState(eqx.Module):
    """Parameters of both sides' rewards, and the forward model at them."""

    parameters: Sides[Any]
    solution: Sides[Ascent]
    optimiser: optax.OptState


class ContinuousMAIRL(eqx.Module):
    """Two-sided feature matching: `steps` steps an iteration, each after `solver_steps` of the forward model."""

    solver: Pathwise
    own_reward: TransitionReward
    rewards: Sides[AbstractTransitionReward]
    regularisation: float
    steps: int = eqx.field(static=True)
    solver_steps: int = eqx.field(static=True)
    optimiser: optax.GradientTransformation = eqx.field(static=True)

    def init(self, key: PRNGKeyArray) -> ContinuousMAIRLState:
        """Random parameters in the unit ball, and random policies."""
        learner_key, expert_key, policy_key = jax.random.split(key, 3)
        parameters: Any = Sides(
            self.rewards.learner.initial_parameters(learner_key), self.rewards.expert.initial_parameters(expert_key)
        )
        return ContinuousMAIRLState(parameters, self.solver.init(policy_key), self.optimiser.init(parameters))

    def modelled_rewards(self, parameters: Sides[Any]) -> Sides[TransitionReward]:
        """r^θ_l + r_li and r^θ_e."""
        return Sides(
            lambda seen: self.rewards.learner(parameters.learner, seen) + self.own_reward(seen),
            lambda seen: self.rewards.expert(parameters.expert, seen),
        )

    def update(
        self, state: ContinuousMAIRLState, demonstrations: Transition, key: PRNGKeyArray
    ) -> ContinuousMAIRLState:
        """One iteration on a share of D* (axes d, T)."""
        starts, discount = first_states(demonstrations), self.solver.discount

        def one_step(number: Array, carry: tuple[Any, Sides[Ascent], Any]) -> tuple[Any, Any, Any]:
            parameters, solution, optimiser = carry
            solution, _ = self.solver.ascend(
                solution, self.modelled_rewards(parameters), jax.random.fold_in(key, number), self.solver_steps
            )
            episodes = episodes_from(self.solver.game, policies_of(solution), starts)

            def gradient(reward: AbstractTransitionReward, theta: Array) -> Array:
                return reward_gap(reward, theta, episodes, demonstrations, discount) + self.regularisation * theta

            gradients: Any = Sides(
                gradient(self.rewards.learner, parameters.learner),
                across(gradient(self.rewards.expert, parameters.expert), parameters.expert),
            )
            step, optimiser = self.optimiser.update(gradients, optimiser, parameters)
            moved: Any = optax.apply_updates(parameters, step)
            # What the expert does shows its reward up to a factor; the learner's has r_li beside it.
            projected = Sides(
                optax.projections.projection_l2_ball(moved.learner, 1.0),
                optax.projections.projection_l2_sphere(moved.expert, 1.0),
            )
            return projected, solution, optimiser

        carry = (state.parameters, state.solution, state.optimiser)
        return ContinuousMAIRLState(*jax.lax.fori_loop(0, self.steps, one_step, carry))
