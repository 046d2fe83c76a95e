"""Payoffs over (state, learner's action, expert's action), dense or structured.

Solvers never look at entries: they ask a payoff for expectations over one side's mixed action, and for the solution of
the linear system that couples two sides' log-policies. A payoff with structure answers both in O(actions) instead of
O(actions²).
"""

import abc
from typing import Self

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.types import AnyArray, Sides


class AbstractPayoff(eqx.Module):
    """A real-valued function of (a_l, a_e), with any leading axes (states, seeds)."""

    @property
    @abc.abstractmethod
    def number_of_actions(self) -> tuple[int, int]:
        """(A_l, A_e)."""

    @abc.abstractmethod
    def learner_values(self, expert_policy: Float[Array, "*b A_e"]) -> Float[Array, "*b A_l"]:
        """E_{a_e~π_e} payoff(·, a_e): the learner's action values."""

    @abc.abstractmethod
    def expert_values(self, learner_policy: Float[Array, "*b A_l"]) -> Float[Array, "*b A_e"]:
        """E_{a_l~π_l} payoff(a_l, ·): the expert's action values."""

    @abc.abstractmethod
    def expected(
        self, learner_policy: Float[Array, "*b A_l"], expert_policy: Float[Array, "*b A_e"]
    ) -> Float[Array, "*b"]:
        """E_{a_l~π_l, a_e~π_e} payoff(a_l, a_e)."""

    @abc.abstractmethod
    def dense(self) -> Float[Array, "*b A_l A_e"]:
        """The full matrix; for tests and small games."""

    @abc.abstractmethod
    def solve_coupled(
        self,
        expert_payoff: "AbstractPayoff",
        policies: Sides,
        inverse_temperature: Float[Array, ""],
        right_hand_sides: Sides,
    ) -> Sides:
        """Solve u − λ Q_l diag(π_e) v = g_l, v − λ Q_eᵀ diag(π_l) u = g_e for (u, v), one stage game.

        `self` is the learner's payoff Q_l, `expert_payoff` is Q_e, of the same form; terms that are constant over a
        side's own actions may be dropped (callers fix them by normalisation). `right_hand_sides` holds (k, A_l) and
        (k, A_e): k systems at once.
        """

    @abc.abstractmethod
    def coupled_sign(
        self, expert_payoff: "AbstractPayoff", policies: Sides, inverse_temperature: Float[Array, ""]
    ) -> Float[Array, ""]:
        """The sign of the determinant of the system that `solve_coupled` solves: −1, 0 or 1."""

    def __add__(self, other: Self) -> Self:
        return jax.tree.map(jnp.add, self, other)

    def __mul__(self, factor: Float[Array, ""] | float) -> Self:
        return jax.tree.map(lambda leaf: factor * leaf, self)

    def __neg__(self) -> Self:
        return jax.tree.map(jnp.negative, self)


class DensePayoff(AbstractPayoff):
    """A payoff without structure: the matrix itself."""

    values: Float[AnyArray, "*b A_l A_e"]

    @property
    def number_of_actions(self) -> tuple[int, int]:
        return self.values.shape[-2], self.values.shape[-1]

    def learner_values(self, expert_policy: Float[Array, "*b A_e"]) -> Float[Array, "*b A_l"]:
        return jnp.einsum("...le,...e->...l", self.values, expert_policy)

    def expert_values(self, learner_policy: Float[Array, "*b A_l"]) -> Float[Array, "*b A_e"]:
        return jnp.einsum("...le,...l->...e", self.values, learner_policy)

    def expected(
        self, learner_policy: Float[Array, "*b A_l"], expert_policy: Float[Array, "*b A_e"]
    ) -> Float[Array, "*b"]:
        return jnp.einsum("...le,...l,...e->...", self.values, learner_policy, expert_policy)

    def dense(self) -> Float[Array, "*b A_l A_e"]:
        return jnp.asarray(self.values)

    def solve_coupled(
        self,
        expert_payoff: AbstractPayoff,
        policies: Sides,
        inverse_temperature: Float[Array, ""],
        right_hand_sides: Sides,
    ) -> Sides:
        learner_actions = self.values.shape[0]
        stacked = jnp.concatenate([right_hand_sides.learner, right_hand_sides.expert], axis=-1)
        solution = jnp.linalg.solve(self._coupled(expert_payoff, policies, inverse_temperature), stacked.T).T
        return Sides(solution[:, :learner_actions], solution[:, learner_actions:])

    def coupled_sign(
        self, expert_payoff: AbstractPayoff, policies: Sides, inverse_temperature: Float[Array, ""]
    ) -> Float[Array, ""]:
        return jnp.linalg.slogdet(self._coupled(expert_payoff, policies, inverse_temperature))[0]

    def _coupled(
        self, expert_payoff: AbstractPayoff, policies: Sides, inverse_temperature: Float[Array, ""]
    ) -> Float[Array, "n n"]:
        learner_actions, expert_actions = self.values.shape
        learner_coupling = inverse_temperature * self.values * policies.expert[None, :]
        expert_coupling = inverse_temperature * expert_payoff.dense().T * policies.learner[None, :]
        return jnp.block(
            [
                [jnp.eye(learner_actions, dtype=self.values.dtype), -learner_coupling],
                [-expert_coupling, jnp.eye(expert_actions, dtype=self.values.dtype)],
            ]
        )


class MatchingPayoff(AbstractPayoff):
    """payoff(a_l, a_e) = learner[a_l] + expert[a_e] + 1[a_l = a_e] match[a_l].

    The form of every payoff on an attack graph: what the defender blocks matters only on the edge that is attacked.
    Actions past the last entry of `match` (a no-op) match nothing.
    """

    learner: Float[Array, "*b A_l"]
    expert: Float[Array, "*b A_e"]
    match: Float[Array, "*b M"]

    @property
    def number_of_actions(self) -> tuple[int, int]:
        return self.learner.shape[-1], self.expert.shape[-1]

    def learner_values(self, expert_policy: Float[Array, "*b A_e"]) -> Float[Array, "*b A_l"]:
        common = jnp.sum(self.expert * expert_policy, axis=-1, keepdims=True)
        matched = self.match * expert_policy[..., : self.match.shape[-1]]
        return self.learner + common + _pad(matched, self.learner.shape[-1])

    def expert_values(self, learner_policy: Float[Array, "*b A_l"]) -> Float[Array, "*b A_e"]:
        common = jnp.sum(self.learner * learner_policy, axis=-1, keepdims=True)
        matched = self.match * learner_policy[..., : self.match.shape[-1]]
        return self.expert + common + _pad(matched, self.expert.shape[-1])

    def expected(
        self, learner_policy: Float[Array, "*b A_l"], expert_policy: Float[Array, "*b A_e"]
    ) -> Float[Array, "*b"]:
        matches = self.match.shape[-1]
        return (
            jnp.sum(self.learner * learner_policy, axis=-1)
            + jnp.sum(self.expert * expert_policy, axis=-1)
            + jnp.sum(self.match * learner_policy[..., :matches] * expert_policy[..., :matches], axis=-1)
        )

    def dense(self) -> Float[Array, "*b A_l A_e"]:
        table = self.learner[..., :, None] + self.expert[..., None, :]
        matched = jnp.arange(self.match.shape[-1])
        return table.at[..., matched, matched].add(self.match)

    def solve_coupled(
        self,
        expert_payoff: AbstractPayoff,
        policies: Sides,
        inverse_temperature: Float[Array, ""],
        right_hand_sides: Sides,
    ) -> Sides:
        # Only matched actions couple, in pairs: one 2x2 system each.
        matches = self.match.shape[-1]
        to_learner, to_expert = self._couplings(expert_payoff, policies, inverse_temperature)
        determinant = 1.0 - to_learner * to_expert
        g_learner, g_expert = right_hand_sides.learner[:, :matches], right_hand_sides.expert[:, :matches]
        u = (g_learner + to_learner[None, :] * g_expert) / determinant[None, :]
        v = (g_expert + to_expert[None, :] * g_learner) / determinant[None, :]
        return Sides(
            jnp.concatenate([u, right_hand_sides.learner[:, matches:]], axis=-1),
            jnp.concatenate([v, right_hand_sides.expert[:, matches:]], axis=-1),
        )

    def coupled_sign(
        self, expert_payoff: AbstractPayoff, policies: Sides, inverse_temperature: Float[Array, ""]
    ) -> Float[Array, ""]:
        to_learner, to_expert = self._couplings(expert_payoff, policies, inverse_temperature)
        return jnp.prod(jnp.sign(1.0 - to_learner * to_expert))

    def _couplings(
        self, expert_payoff: AbstractPayoff, policies: Sides, inverse_temperature: Float[Array, ""]
    ) -> tuple[Float[Array, " M"], Float[Array, " M"]]:
        assert isinstance(expert_payoff, MatchingPayoff), "both sides' payoffs have the same form"
        matches = self.match.shape[-1]
        to_learner = inverse_temperature * self.match * policies.expert[:matches]
        return to_learner, inverse_temperature * expert_payoff.match * policies.learner[:matches]


def _pad(values: Float[Array, "*b M"], length: int) -> Float[Array, "*b A"]:
    missing = length - values.shape[-1]
    return jnp.concatenate([values, jnp.zeros((*values.shape[:-1], missing), values.dtype)], axis=-1)
