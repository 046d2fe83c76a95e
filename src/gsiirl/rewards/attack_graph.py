"""Reward features of the attack graph, and the true rewards of a network.

The same features serve every algorithm. The attacker's:

    φ_e(s, a) = (P(j is newly compromised | s, a))_j  ++  (−1[a_e = e])_e      weights: value of node j, cost of edge e

The defender's expert-dependent reward has −φ_e: its weights are losses, and its share in the attacker's costs (1 in the
zero-sum variant, where r_ld = −r_e, and 0 in the general-sum one). A commitment may also be rewarded for the edge it
blocks, which lets the learner express what it wants to do and not only what it suffers.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from gsiirl.games.attack_graph import AttackGraph
from gsiirl.games.payoff import MatchingPayoff
from gsiirl.rewards.linear import AbstractFeatures
from gsiirl.scenarios.network import AttackNetwork
from gsiirl.types import Sides


class AttackFeatures(AbstractFeatures):
    """±φ_e of the module's docstring: N node features, then E edge features."""

    game: AttackGraph
    sign: float = eqx.field(static=True)
    names: tuple[str, ...] = eqx.field(static=True)

    def __call__(self, state: Int[Array, ""], actions: Sides[Int[Array, ""]]) -> Float[Array, " m"]:
        edges = self.game.number_of_edges
        attacks = actions.expert < edges
        edge = jnp.minimum(actions.expert, edges - 1)
        gained = jnp.where(attacks & (actions.learner != actions.expert), self.game.success[state, edge], 0.0)
        node = jnp.zeros(self.game.number_of_nodes, gained.dtype).at[self.game.targets[edge]].set(gained)
        cost = jnp.where(jnp.arange(edges) == actions.expert, -1.0, 0.0).astype(gained.dtype)
        return self.sign * jnp.concatenate([node, cost])

    def payoff(self, weights: Float[Array, " m"]) -> MatchingPayoff:
        values, costs = weights[: self.game.number_of_nodes], weights[self.game.number_of_nodes :]
        gains = jnp.broadcast_to(self.sign * values[self.game.targets], self.game.success.shape)
        payoff = self.game.payoff_of_success(gains)
        paid = jnp.pad(self.sign * costs, (0, payoff.expert.shape[1] - costs.shape[0]))
        return MatchingPayoff(payoff.learner, payoff.expert - paid[None, :], payoff.match)


class CommitmentFeatures(AbstractFeatures):
    """What a commitment of the defender may be rewarded for: −φ_e, and 1[a_l = e] for every edge (N + 2E features)."""

    attack: AttackFeatures
    names: tuple[str, ...] = eqx.field(static=True)

    def __call__(self, state: Int[Array, ""], actions: Sides[Int[Array, ""]]) -> Float[Array, " m"]:
        attack = self.attack(state, actions)
        blocked = (jnp.arange(self.attack.game.number_of_edges) == actions.learner).astype(attack.dtype)
        return jnp.concatenate([attack, blocked])

    def payoff(self, weights: Float[Array, " m"]) -> MatchingPayoff:
        inner = len(self.attack.names)
        payoff = self.attack.payoff(weights[:inner])
        blocked = jnp.pad(weights[inner:], (0, payoff.learner.shape[1] - self.attack.game.number_of_edges))
        return MatchingPayoff(payoff.learner + blocked[None, :], payoff.expert, payoff.match)


def attack_features(game: AttackGraph) -> AttackFeatures:
    """The attacker's features φ_e."""
    names = [f"value of {node}" for node in game.node_names] + [f"cost of {edge}" for edge in game.edge_names]
    return AttackFeatures(game=game, sign=1.0, names=tuple(names))


def dependent_features(game: AttackGraph) -> AttackFeatures:
    """The defender's expert-dependent features −φ_e."""
    losses = [f"loss of {node}" for node in game.node_names]
    shares = [f"attacker's cost of {edge}" for edge in game.edge_names]
    return AttackFeatures(game=game, sign=-1.0, names=tuple(losses + shares))


def commitment_features(game: AttackGraph) -> CommitmentFeatures:
    """The features of a commitment."""
    dependent = dependent_features(game)
    blocks = (f"block of {edge}" for edge in game.edge_names)
    return CommitmentFeatures(attack=dependent, names=(*dependent.names, *blocks))


def expert_weights(network: AttackNetwork) -> np.ndarray:
    """Weights of the true r_e: node values, then edge costs (N + E,)."""
    return np.concatenate([network.value, network.attack_cost])


def dependent_weights(network: AttackNetwork) -> np.ndarray:
    """Weights of the true r_ld among a commitment's features: losses, shares in costs, nothing for blocks (N + 2E,)."""
    share = network.attack_cost if network.variant == "zero_sum" else np.zeros_like(network.attack_cost)
    return np.concatenate([network.criticality, share, np.zeros_like(share)])


def own_reward(game: AttackGraph, network: AttackNetwork) -> MatchingPayoff:
    """r_li(a_l) = −(cost to block the edge); a no-op costs nothing."""
    payoff = game.payoff_of_success(jnp.zeros_like(game.success))
    paid = jnp.pad(jnp.asarray(network.block_cost), (0, int(game.no_op.learner)))
    return MatchingPayoff(payoff.learner - paid[None, :], payoff.expert, payoff.match)
