"""GSIIRL: Algorithm 1 of the paper, mended where docs/deviations.md says.

For k = 0, …, K − 1:

    D_k        ← the expert's demonstrations while the learner plays π_l(k)       line 4, into the memory
    θ_e(k+1)   ← projected gradient steps on L, warm-started at θ_e(k)            lines 5-9
    θ          ← θ_l(k), or the r_ld fitted to the values read: whichever has the greater f(·, θ_e(k+1))
    g          ← ∇_{θ_l} f(θ, θ_e(k+1))                                           lines 11-14, well specified
    θ_l(k+1)   ← Proj(θ + step of g)                                              line 15, ascent

with f(θ_l, θ_e) = E^π[Σ_t γ^t (r_ld + r_li)] for the accessed values of r_ld, and π the forward model at
(r^θ_l + r_li, r^θ_e).
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.equilibria.logit import Logit, LogitSolution
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.interaction import AbstractLearner, Demonstrator, live
from gsiirl.irl.dependent_reward import DependentValue, LeastSquares
from gsiirl.irl.expectations import expected_return, sampled_reward_gradient
from gsiirl.irl.maximum_likelihood import MaximumLikelihood
from gsiirl.irl.memory import Memory
from gsiirl.rewards.linear import Linear
from gsiirl.types import Interaction, Sides


class GSIIRLState(eqx.Module):
    """What GSIIRL carries from one iteration to the next.

    `commitment` θ_l is the reward to act on, what the policy is made of; it is no estimate of r_ld. That estimate comes
    from `accessed`, the values read along what was visited.
    """

    commitment: Float[Array, " n"]
    expert_parameters: Float[Array, " m"]
    memory: Memory
    accessed: LeastSquares
    upper_optimiser: optax.OptState
    lower_optimiser: optax.OptState


class Learned(eqx.Module):
    """What a learner comes out with; the three rewards are weights of their features, in reward units.

    `expert_reward` estimates r_e and `dependent_reward` r_ld; `commitment` is the reward the policy is made of.
    `solution.policies.learner` is the policy to live by, `solution.policies.expert` what the learner expects of the
    expert.
    """

    state: GSIIRLState
    expert_reward: Float[Array, " m"]
    dependent_reward: Float[Array, " n"]
    commitment: Float[Array, " n"]
    solution: LogitSolution


class GSIIRL(AbstractLearner[GSIIRLState]):
    """General-sum interactive inverse reinforcement learning with the response `well_specified`.

    `own_reward` is r_li, known; `dependent_value` reads r_ld; `dependent_reward` and `expert_reward` are the parametric
    rewards r_ld^θ_l (of the commitment and of the fit alike) and r_e^θ_e. `optimiser` turns −∇_{θ_l} f into a step on
    θ_l; `remembered` interactions are averaged over in the lower level; `ridge` regularises the fit of r_ld.
    """

    game: AbstractTabularGame
    own_reward: AbstractPayoff
    dependent_value: DependentValue
    dependent_reward: Linear
    expert_reward: Linear
    forward_model: Logit
    lower_level: MaximumLikelihood
    discount: float
    ridge: float
    optimiser: optax.GradientTransformation = eqx.field(static=True)
    remembered: int = eqx.field(static=True)

    @classmethod
    def create(
        cls,
        game: AbstractTabularGame,
        *,
        own_reward: AbstractPayoff,
        dependent_value: DependentValue,
        dependent_reward: Linear,
        expert_reward: Linear,
        temperature: float,
        discount: float = 0.95,
        regularisation: float = 1e-3,
        inner_steps: int = 10,
        inner_step_size: float = 0.02,
        step_size: float = 1.0,
        step_decay: float = 20.0,
        remembered: int = 16,
    ) -> "GSIIRL":
        """The default preset: Adam in both levels.

        `temperature` is τ in reward units, the expert's and the forward model's; `regularisation` is λ. The upper
        level's first step changes rewards by about step_size · τ, and is halved after `step_decay` iterations; the
        lower level takes `inner_steps` steps of `inner_step_size` in the unit ball.
        """
        # A step on θ changes rewards by scale times as much; what matters to a policy is that change over τ.
        first_step = step_size * temperature / float(dependent_reward.scale)
        return cls(
            game=game,
            own_reward=own_reward,
            dependent_value=dependent_value,
            dependent_reward=dependent_reward,
            expert_reward=expert_reward,
            forward_model=Logit(temperature),
            lower_level=MaximumLikelihood(
                temperature=temperature,
                discount=discount,
                regularisation=regularisation,
                steps=inner_steps,
                optimiser=optax.adam(inner_step_size),
            ),
            discount=discount,
            ridge=regularisation,
            optimiser=optax.adam(lambda k: first_step / (1.0 + k / step_decay)),
            remembered=remembered,
        )

    def fit(
        self, expert: Demonstrator, iterations: int = 50, trajectories: int = 100, seed: int = 0, progress: bool = True
    ) -> "Learned":
        """Live with `expert` for `iterations` rounds of `trajectories` episodes, and say what was learned."""
        state = live(self, expert, iterations, trajectories, seed, progress)
        return Learned(
            state=state,
            expert_reward=self.expert_reward.scale * state.expert_parameters,
            dependent_reward=self.dependent_reward.scale * self.fitted_dependent_reward(state),
            commitment=self.dependent_reward.scale * state.commitment,
            solution=eqx.filter_jit(self.propose)(state),
        )

    def init(self, key: PRNGKeyArray) -> GSIIRLState:
        dtype = self.game.initial.dtype
        commitment_key, expert_key = jax.random.split(key)
        shape = (self.game.horizon, self.game.number_of_states, self.game.number_of_actions.learner)
        commitment = self.dependent_reward.initial_parameters(commitment_key, dtype)
        expert_parameters = self.expert_reward.initial_parameters(expert_key, dtype)
        return GSIIRLState(
            commitment=commitment,
            expert_parameters=expert_parameters,
            memory=Memory.empty(self.remembered, shape, self.expert_reward.number_of_parameters, dtype),
            accessed=LeastSquares.empty(self.dependent_reward.number_of_parameters, dtype),
            upper_optimiser=self.optimiser.init(commitment),
            lower_optimiser=self.lower_level.optimiser.init(expert_parameters),
        )

    def propose(self, state: GSIIRLState) -> LogitSolution:
        return self._forward(state.commitment, state.expert_parameters)

    def update(self, state: GSIIRLState, interaction: Interaction, key: PRNGKeyArray) -> GSIIRLState:
        demonstrations = interaction.demonstrations
        demonstrated = sampled_reward_gradient(
            self.expert_reward, demonstrations, self.discount, self.game.initial.dtype
        )
        memory = state.memory.remember(key, interaction.learner_policy, demonstrated)
        expert_parameters, lower_optimiser = self.lower_level.fit(
            self.game, self.expert_reward, state.expert_parameters, state.lower_optimiser, memory
        )
        accessed = state.accessed.observe(self.dependent_reward, self.dependent_value, demonstrations)
        start, gradient = self._ascend_from(state.commitment, accessed.solve(self.ridge), expert_parameters)
        step, upper_optimiser = self.optimiser.update(-gradient, state.upper_optimiser, start)
        return GSIIRLState(
            commitment=optax.projections.projection_l2_ball(optax.apply_updates(start, step), 1.0),
            expert_parameters=expert_parameters,
            memory=memory,
            accessed=accessed,
            upper_optimiser=upper_optimiser,
            lower_optimiser=lower_optimiser,
        )

    def objective(self, commitment: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> Float[Array, ""]:
        """f(θ_l, θ_e), the learner's discounted return under the accessed values (problem (2)); it is maximised."""
        policies = self._forward(commitment, expert_parameters).policies
        accessed = self.dependent_value.table + self.own_reward
        return expected_return(self.game, accessed, policies, self.discount)

    def fitted_dependent_reward(self, state: GSIIRLState) -> Float[Array, " n_d"]:
        """Parameters of r_ld, by regularised least squares over the values read so far."""
        return state.accessed.solve(self.ridge)

    def _ascend_from(
        self, commitment: Float[Array, " n"], fitted: Float[Array, " n"], expert_parameters: Float[Array, " m"]
    ) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        """θ_l itself, or the fitted r_ld where committing to that honestly would bring more; and ∇_{θ_l} f there.

        The ascent is local; from a random start it can end below what the learner would get by acting on its own
        reward.
        """
        candidates = jnp.stack([commitment, fitted])
        returns, gradients = jax.vmap(jax.value_and_grad(self.objective), (0, None))(candidates, expert_parameters)
        best = jnp.argmax(returns)
        return candidates[best], gradients[best]

    def _forward(self, commitment: Float[Array, " n"], expert_parameters: Float[Array, " m"]) -> LogitSolution:
        rewards = Sides(
            self.dependent_reward.payoff(commitment) + self.own_reward, self.expert_reward.payoff(expert_parameters)
        )
        return self.forward_model.solve(self.game, rewards, self.discount)
