"""The attack graph: a defender and an attacker pick one edge each, every step (paper A.10.3)."""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, PRNGKeyArray

from gsiirl.errors import InputError
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import MatchingPayoff
from gsiirl.scenarios.network import AttackNetwork
from gsiirl.scenarios.reachable import AttackMoves, TooManyStatesError, reachable_states, starting_state, words
from gsiirl.types import AnyArray, Sides

MOST_ATTACKS = 2**26
"""Pairs of a state and an edge, of each of which a game holds three numbers."""


class AttackGraph(AbstractTabularGame):
    """Dynamics of an attack graph with N nodes and E edges, over the S states that can be reached.

    A state is the set of compromised nodes, a bitmask in `masks` (S,), or (S, words) where there are many nodes. The
    attack on edge e = (i → j) from state s succeeds with `success[s, e]` = probability of e · 1[i ∈ s or e is an entry
    edge] · 1[j ∉ s], unless the defender picked e too. Actions are edges, 0 to E − 1; action E is the no-op of a side
    that has one.
    """

    masks: Int[Array, "S *words"]
    success: Float[Array, "S E"]
    successors: Int[Array, "S E"]
    predecessors: Int[Array, "S E"]
    targets: Int[Array, " E"]
    initial: Float[AnyArray, " S"]
    horizon: int = eqx.field(static=True)
    no_op: Sides[bool] = eqx.field(static=True)
    number_of_nodes: int = eqx.field(static=True)
    edge_names: tuple[str, ...] = eqx.field(static=True)
    node_names: tuple[str, ...] = eqx.field(static=True)

    @classmethod
    def create(
        cls,
        network: AttackNetwork,
        horizon: int = 10,
        *,
        learner_no_op: bool = False,
        expert_no_op: bool = False,
        starts: Sequence[int] | None = None,
    ) -> "AttackGraph":
        """Build the game of a network.

        `starts` are bitmasks of equally likely initial states; without it every episode starts with the footholds alone
        compromised.

        Raises:
            InputError: when the horizon is not positive, or so many states can be reached that they fill any memory.
        """
        if horizon < 1:
            raise InputError("horizon", f"{horizon} is no number of steps", "give 1 or more")
        moves = AttackMoves(network)
        starts = [starting_state(network)] if starts is None else starts
        most = MOST_ATTACKS // len(network.edge_source)
        try:
            masks = reachable_states(network, starts, most)
        except TooManyStatesError:
            raise InputError("network", f"its game has more than {most:,} states", "use a smaller one") from None
        active = moves.usable(masks)
        after = masks[:, None] | moves.target_bit
        successors = np.searchsorted(masks, np.where(active, after, masks[:, None]))
        # The state an edge led here from, where there is one; elsewhere the state itself, from which no mass flows in.
        before = masks[:, None] & ~moves.target_bit
        place = np.minimum(np.searchsorted(masks, before), masks.size - 1)
        arrived = (before != masks[:, None]) & (masks[place] == before) & active[place, np.arange(active.shape[1])]
        predecessors = np.where(arrived, place, np.arange(masks.size)[:, None])
        initial = np.zeros(masks.size)
        initial[np.searchsorted(masks, moves.masks(starts))] = 1.0
        return cls(
            masks=jnp.asarray(words(masks)),
            success=jnp.asarray(active * np.asarray(network.success_probability)),
            successors=jnp.asarray(successors),
            predecessors=jnp.asarray(predecessors),
            targets=jnp.asarray(np.asarray(network.edge_target)),
            initial=jnp.asarray(initial / initial.sum()),
            horizon=horizon,
            no_op=Sides(learner_no_op, expert_no_op),
            number_of_nodes=len(network.node_names),
            edge_names=tuple(network.edge_names),
            node_names=tuple(network.node_names),
        )

    @property
    def number_of_edges(self) -> int:
        """E."""
        return self.targets.shape[0]

    @property
    def number_of_actions(self) -> Sides[int]:
        return Sides(self.number_of_edges + self.no_op.learner, self.number_of_edges + self.no_op.expert)

    def payoff_of_success(self, gains: Float[Array, "S E"]) -> MatchingPayoff:
        """gains[s, e] if the attack on e succeeds, in expectation: success · gains · 1[a_l ≠ a_e]."""
        expected = self.success * gains
        learner = jnp.zeros((self.number_of_states, self.number_of_actions.learner), expected.dtype)
        padding = ((0, 0), (0, int(self.no_op.expert)))
        return MatchingPayoff(learner=learner, expert=jnp.pad(expected, padding), match=-expected)

    def continuation(self, values: Float[Array, " S"]) -> MatchingPayoff:
        payoff = self.payoff_of_success(values[self.successors] - values[:, None])
        return MatchingPayoff(payoff.learner, payoff.expert + values[:, None], payoff.match)

    def advance(self, distribution: Float[Array, " S"], policies: Sides[Float[Array, "..."]]) -> Float[Array, " S"]:
        edges = self.number_of_edges
        met = 1.0 - policies.learner[:, :edges]
        flow = distribution[:, None] * policies.expert[:, :edges] * self.success * met
        # A gather from predecessors, not a scatter to successors: the same sum, and much faster on a CPU.
        arriving = jnp.where(
            self.predecessors != jnp.arange(self.number_of_states)[:, None],
            flow[self.predecessors, jnp.arange(edges)],
            0.0,
        )
        return distribution - jnp.sum(flow, axis=1) + jnp.sum(arriving, axis=1)

    def reset(self, key: PRNGKeyArray) -> Int[Array, ""]:
        return jax.random.categorical(key, jnp.log(self.initial))

    def step(self, key: PRNGKeyArray, state: Int[Array, ""], actions: Sides[Int[Array, ""]]) -> Int[Array, ""]:
        edge = jnp.minimum(actions.expert, self.number_of_edges - 1)
        open_to_attack = (actions.expert < self.number_of_edges) & (actions.learner != actions.expert)
        succeeds = jax.random.uniform(key, dtype=self.success.dtype) < self.success[state, edge]
        return jnp.where(open_to_attack & succeeds, self.successors[state, edge], state)

    def possible(
        self, states: Int[AnyArray, " n"], actions: Sides[Int[AnyArray, " n"]], following: Int[AnyArray, " n"]
    ) -> Bool[np.ndarray, " n"]:
        states, following, attack = np.asarray(states), np.asarray(following), np.asarray(actions.expert)
        edge = np.minimum(attack, self.number_of_edges - 1)
        open_to_attack = (attack < self.number_of_edges) & (np.asarray(actions.learner) != attack)
        success = np.where(open_to_attack, np.asarray(self.success)[states, edge], 0.0)
        arrived = following == np.asarray(self.successors)[states, edge]
        return (arrived & (success > 0)) | ((following == states) & (success < 1))
