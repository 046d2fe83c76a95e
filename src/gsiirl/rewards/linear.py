"""Linear rewards r^θ(s, a) = scale · θ·φ(s, a) with θ in the closed unit ball."""

import abc
import math

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from gsiirl.games.payoff import AbstractPayoff, DensePayoff
from gsiirl.types import AnyArray, Sides


class AbstractFeatures(eqx.Module):
    """m reward features of a tabular game: of one (s, a), and of all at once as a payoff that is linear in weights."""

    names: eqx.AbstractVar[tuple[str, ...]]

    @property
    def number(self) -> int:
        """m."""
        return len(self.names)

    @abc.abstractmethod
    def __call__(self, state: Int[Array, ""], actions: Sides[Int[Array, ""]]) -> Float[Array, " m"]:
        """φ(s, a)."""

    @abc.abstractmethod
    def payoff(self, weights: Float[Array, " m"]) -> AbstractPayoff:
        """weights·φ(s, a) over all states and actions."""


class TabularFeatures(AbstractFeatures):
    """Features given as a table φ[s, a_l, a_e, m]."""

    table: Float[AnyArray, "S A_l A_e m"]
    names: tuple[str, ...] = eqx.field(static=True, default=())

    @property
    def number(self) -> int:
        return self.table.shape[-1]

    def __call__(self, state: Int[Array, ""], actions: Sides[Int[Array, ""]]) -> Float[Array, " m"]:
        return jnp.asarray(self.table)[state, actions.learner, actions.expert]

    def payoff(self, weights: Float[Array, " m"]) -> DensePayoff:
        return DensePayoff(jnp.einsum("slem,m->sle", self.table, weights))


class IndicatorFeatures(AbstractFeatures):
    """One weight for each (state, learner's action, expert's action): the reward is any table.

    Weight number (s · A_l + a_l) · A_e + a_e is r(s, a_l, a_e). No table of features is held.
    """

    shape: tuple[int, int, int] = eqx.field(static=True)
    names: tuple[str, ...] = eqx.field(static=True, default=())

    @property
    def number(self) -> int:
        return math.prod(self.shape)

    def __call__(self, state: Int[Array, ""], actions: Sides[Int[Array, ""]]) -> Float[Array, " m"]:
        return jax.nn.one_hot(self.place(state, actions), self.number)

    def place(self, state: Int[Array, "*b"], actions: Sides[Int[Array, "*b"]]) -> Int[Array, "*b"]:
        """The number of the weight of (s, a)."""
        _, learner_actions, expert_actions = self.shape
        return (state * learner_actions + actions.learner) * expert_actions + actions.expert

    def payoff(self, weights: Float[Array, " m"]) -> DensePayoff:
        return DensePayoff(weights.reshape(self.shape))


class Linear(eqx.Module):
    """r^θ(s, a) = scale · θ·φ(s, a), θ ∈ R^m with ‖θ‖ ≤ 1.

    `scale` is in reward units and bounds what can be expressed.
    """

    features: AbstractFeatures
    scale: float | Float[Array, ""]

    @property
    def number_of_parameters(self) -> int:
        """m."""
        return self.features.number

    def __call__(
        self, parameters: Float[Array, " m"], state: Int[Array, ""], actions: Sides[Int[Array, ""]]
    ) -> Float[Array, ""]:
        return self.scale * jnp.vdot(parameters, self.features(state, actions))

    def payoff(self, parameters: Float[Array, " m"]) -> AbstractPayoff:
        """r^θ over all states and actions."""
        return self.features.payoff(self.scale * parameters)

    def initial_parameters(self, key: Array, dtype: jnp.dtype) -> Float[Array, " m"]:
        """θ(0), uniform in the unit ball."""
        return jax.random.ball(key, self.number_of_parameters, dtype=dtype)
