"""Lower levels: from what the expert did to its reward, each a part that a learner holds.

Weights are in units of the expert's temperature.
"""

import abc
from typing import Generic, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.games.base import uniform_policy
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood, Seen
from gsiirl.irl.expectations import sampled_reward_gradient
from gsiirl.irl.likelihood import played_gradient
from gsiirl.irl.maximum_likelihood import MaximumLikelihood, constant_steps
from gsiirl.irl.memory import Memory, Played
from gsiirl.irl.posterior import Draws, Inference, Posterior
from gsiirl.rewards.linear import Linear
from gsiirl.types import Trajectories

State = TypeVar("State")


class AbstractLowerLevel(eqx.Module, Generic[State]):
    """How a learner estimates the expert's reward from interactions."""

    @property
    @abc.abstractmethod
    def likelihood(self) -> ConditionalLikelihood:
        """The likelihood that the estimate is of, with the game, the features and the discount."""

    @abc.abstractmethod
    def init(self, capacity: int) -> State:
        """Before any interaction; up to `capacity` of them will be remembered."""

    @abc.abstractmethod
    def learn(
        self, state: State, learner_policy: Float[Array, "T S A_l"], demonstrations: Trajectories, key: PRNGKeyArray
    ) -> State:
        """Take in one interaction."""

    @abc.abstractmethod
    def estimate(self, state: State) -> Float[Array, " m"]:
        """θ̂ in units of the temperature."""

    @abc.abstractmethod
    def report(self, state: State) -> dict[str, Float[Array, ""]]:
        """How well the estimate converged, by name."""


class LikelihoodState(eqx.Module):
    """What is remembered, and what follows from it."""

    memory: Memory[Seen]
    posterior: Posterior


class LikelihoodLevel(AbstractLowerLevel[LikelihoodState]):
    """The conditional likelihood with a Gaussian prior, brought to convergence in every iteration (the default)."""

    inference: Inference

    @property
    def likelihood(self) -> ConditionalLikelihood:
        return self.inference.likelihood

    def init(self, capacity: int) -> LikelihoodState:
        game = self.likelihood.game
        policy = uniform_policy(game)
        counts = jnp.zeros((*policy.shape[:2], game.number_of_actions.expert), policy.dtype)
        return LikelihoodState(Memory.empty(capacity, Seen(policy, counts)), self.inference.start(policy.dtype))

    def learn(
        self,
        state: LikelihoodState,
        learner_policy: Float[Array, "T S A_l"],
        demonstrations: Trajectories,
        key: PRNGKeyArray,
    ) -> LikelihoodState:
        memory_key, fit_key = jax.random.split(key)
        memory = state.memory.remember(memory_key, self.likelihood.seen(learner_policy, demonstrations))
        return LikelihoodState(memory, self.inference.fit(state.posterior, memory, fit_key))

    def estimate(self, state: LikelihoodState) -> Float[Array, " m"]:
        return state.posterior.mean

    def draws(self, state: LikelihoodState, number: int, key: PRNGKeyArray) -> Draws:
        """Weighted draws from the posterior."""
        return self.inference.draws(state.posterior, state.memory, number, key)

    def equal_draws(self, state: LikelihoodState, number: int, key: PRNGKeyArray) -> Float[Array, "K m"]:
        """Draws from the posterior that count alike."""
        return self.inference.equal_draws(state.posterior, state.memory, number, key)

    def report(self, state: LikelihoodState) -> dict[str, Float[Array, ""]]:
        dtype = state.posterior.mean.dtype
        return {
            "fit_decrement": state.posterior.decrement,
            "fit_converged": state.posterior.converged.astype(dtype),
            "fit_steps": state.posterior.steps.astype(dtype),
            "prior_deviation": state.posterior.prior_precision**-0.5,
        }


class MatchingState(eqx.Module):
    """What is remembered, the parameters in the unit ball, and Adam's state."""

    memory: Memory[Played]
    parameters: Float[Array, " m"]
    optimiser: optax.OptState


class MatchingLevel(AbstractLowerLevel[MatchingState]):
    """Lemma 1's feature matching: a few projected Adam steps an iteration along μ_e(π_l, θ) − μ̂_e(D).

    `reward` is scale · θ·φ in units of the temperature, θ in the unit ball; `regularisation` is λ.
    """

    model: ConditionalLikelihood
    reward: Linear
    regularisation: float | Float[Array, ""]
    steps: int = eqx.field(static=True, default=10)
    step_size: float = eqx.field(static=True, default=0.02)

    @property
    def likelihood(self) -> ConditionalLikelihood:
        return self.model

    @property
    def _loop(self) -> MaximumLikelihood:
        return MaximumLikelihood(1.0, constant_steps(self.steps), optax.adam(self.step_size))

    def init(self, capacity: int) -> MatchingState:
        policy = uniform_policy(self.likelihood.game)
        parameters = jnp.zeros(self.reward.number_of_parameters, policy.dtype)
        memory = Memory.empty(capacity, Played(policy, parameters))
        return MatchingState(memory, parameters, self._loop.optimiser.init(parameters))

    def learn(
        self,
        state: MatchingState,
        learner_policy: Float[Array, "T S A_l"],
        demonstrations: Trajectories,
        key: PRNGKeyArray,
    ) -> MatchingState:
        discount = self.likelihood.discount
        demonstrated = sampled_reward_gradient(self.reward, demonstrations, discount, learner_policy.dtype)
        return self.match(state, Played(learner_policy, demonstrated), key)

    def match(self, state: MatchingState, played: Played, key: PRNGKeyArray) -> MatchingState:
        """The state after an interaction of which μ̂_e is known, be it from samples or exact."""
        game, discount = self.likelihood.game, self.likelihood.discount
        memory = state.memory.remember(key, played)

        def gradient(parameters: Array) -> Array:
            each = jax.vmap(
                lambda played: played_gradient(
                    game, self.reward, parameters, played.learner_policy, played.demonstrated, 1.0, discount
                )
            )(memory.kept)
            return jnp.mean(each, axis=0, where=memory.filled[:, None]) + self.regularisation * parameters

        parameters, optimiser = self._loop.fit(gradient, state.parameters, state.optimiser, state.memory.count)
        return MatchingState(memory, parameters, optimiser)

    def estimate(self, state: MatchingState) -> Float[Array, " m"]:
        return self.reward.scale * state.parameters

    def report(self, state: MatchingState) -> dict[str, Float[Array, ""]]:
        return {}
