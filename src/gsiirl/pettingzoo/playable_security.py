"""The attack graph, one step at a time."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, PRNGKeyArray

from gsiirl.games.attack_graph import AttackGraph
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.pettingzoo.playable import AbstractPlayable, Bounds
from gsiirl.scenarios.reachable import WORD
from gsiirl.types import Sides


class PlayableSecurity(AbstractPlayable):
    """An attack graph with both true rewards: both sides see which nodes are compromised.

    A step pays r_l(s, a) and r_e(s, a), in which the success of an attack counts by its probability: what the package
    reports returns of. Whether the attack succeeds is drawn, and shows in the next observation.
    """

    game: AttackGraph
    rewards: Sides[AbstractPayoff]
    compromised: Float[Array, "S N"]

    @classmethod
    def create(cls, game: AttackGraph, rewards: Sides[AbstractPayoff]) -> "PlayableSecurity":
        """The game with rewards r_l and r_e over (S, A_l, A_e)."""
        return cls(game, rewards, jnp.asarray(compromised_nodes(game)))

    @property
    def horizon(self) -> int:
        return self.game.horizon

    @property
    def action_number(self) -> Sides[int]:
        return self.game.number_of_actions

    @property
    def action_size(self) -> None:
        return None

    @property
    def bounds(self) -> Sides[Bounds]:
        size = self.game.number_of_nodes + 1
        return Sides(*(([0.0] * size, [1.0] * size) for _ in range(2)))

    def reset(self, key: PRNGKeyArray) -> Int[Array, ""]:
        return self.game.reset(key)

    def step(
        self, key: PRNGKeyArray, state: Int[Array, ""], actions: Sides[Array]
    ) -> tuple[Int[Array, ""], Sides[Float[Array, ""]]]:
        def paid(payoff: AbstractPayoff) -> Float[Array, ""]:
            here = jax.tree.map(lambda leaf: leaf[state], payoff)
            chosen = jax.tree.map(
                lambda action, number: jax.nn.one_hot(action, number), actions, self.game.number_of_actions
            )
            return here.expected(chosen.learner, chosen.expert)

        rewards = Sides(paid(self.rewards.learner), paid(self.rewards.expert))
        return self.game.step(key, state, actions), rewards

    def observe(self, state: Int[Array, ""], time: Float[Array, ""]) -> Sides[Float[Array, " o"]]:
        seen = jnp.append(self.compromised[state], time)
        return Sides(seen, seen)


def compromised_nodes(game: AttackGraph) -> np.ndarray:
    """1 for each node that is compromised in a state, else 0 (S, N), 32-bit."""
    masks = np.asarray(game.masks).reshape(game.number_of_states, -1)
    nodes = np.arange(game.number_of_nodes)
    return ((masks[:, nodes // WORD] >> nodes % WORD) & 1).astype(np.float32)
