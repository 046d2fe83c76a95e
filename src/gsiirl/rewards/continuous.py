"""Rewards of continuous games: functions r(s, a, s') with parameters in the closed unit ball.

The dynamics are deterministic, so that r(s, a, s') is a function of (s, a).
"""

import abc
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.types import Transition

TransitionReward = Callable[[Transition], Float[Array, ""]]
"""r(s, a, s') of one step."""


class AbstractTransitionFeatures(eqx.Module):
    """m reward features φ(s, a, s') of one step, with a name each."""

    names: eqx.AbstractVar[tuple[str, ...]]

    @abc.abstractmethod
    def __call__(self, transition: Transition) -> Float[Array, " m"]:
        """φ(s, a, s')."""


class AbstractTransitionReward(eqx.Module):
    """A parametric reward r^θ(s, a, s'), θ ∈ R^m with ‖θ‖ ≤ 1; `scale` is in reward units."""

    scale: eqx.AbstractVar[float]

    @property
    @abc.abstractmethod
    def names(self) -> tuple[str, ...]:
        """A name for each of the m parameters."""

    @abc.abstractmethod
    def __call__(self, parameters: Float[Array, " m"], transition: Transition) -> Float[Array, ""]:
        """r^θ(s, a, s')."""

    @property
    def number_of_parameters(self) -> int:
        """m."""
        return len(self.names)

    def initial_parameters(self, key: PRNGKeyArray) -> Float[Array, " m"]:
        """θ(0), uniform in the unit ball."""
        return jax.random.ball(key, self.number_of_parameters, dtype=jnp.float32)


class LinearTransitionReward(AbstractTransitionReward):
    """r^θ(s, a, s') = scale · θ·φ(s, a, s')."""

    features: AbstractTransitionFeatures
    scale: float = eqx.field(static=True)

    @property
    def names(self) -> tuple[str, ...]:
        return self.features.names

    def __call__(self, parameters: Float[Array, " m"], transition: Transition) -> Float[Array, ""]:
        return self.scale * jnp.vdot(parameters, self.features(transition))


class NetworkReward(AbstractTransitionReward):
    """r^θ(s, a, s') = scale · w·tanh(W φ(s, a, s') + b): a smooth network of one hidden layer on features φ.

    θ · `reach` collects W (h, m_φ), b (h,) and w (h,): `reach` is how large they can be together while θ is in the unit
    ball. tanh has derivatives of every order, as Assumption 1 of the paper asks.
    """

    features: AbstractTransitionFeatures
    scale: float = eqx.field(static=True)
    hidden: int = eqx.field(static=True, default=16)
    reach: float = eqx.field(static=True, default=10.0)

    @property
    def names(self) -> tuple[str, ...]:
        first = [f"W[{unit}, {name}]" for unit in range(self.hidden) for name in self.features.names]
        rest = [f"{letter}[{unit}]" for letter in "bw" for unit in range(self.hidden)]
        return (*first, *rest)

    def __call__(self, parameters: Float[Array, " m"], transition: Transition) -> Float[Array, ""]:
        inputs = len(self.features.names)
        own = self.reach * parameters
        weights = own[: self.hidden * inputs].reshape(self.hidden, inputs)
        bias, output = own[self.hidden * inputs :].reshape(2, self.hidden)
        return self.scale * jnp.vdot(output, jnp.tanh(weights @ self.features(transition) + bias))


def length(vector: Float[Array, " n"]) -> Float[Array, ""]:
    """‖v‖, with derivative 0 at v = 0."""
    return optax.safe_norm(vector, 0.0)


def mean_return(reward: TransitionReward, episodes: Transition, discount: float) -> Float[Array, ""]:
    """(1/d) Σ_i Σ_t γ^t r(s_it, a_it, s_i,t+1) over d episodes of T steps (axes d, T)."""
    values = jax.vmap(jax.vmap(reward))(episodes)
    weights = discount ** jnp.arange(values.shape[1], dtype=values.dtype)
    return jnp.mean(values @ weights)
