"""Small games for tests, as the library's types, beside their dense numpy form for the oracles."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.equilibria import Logit, LogitSolution
from gsiirl.games import DensePayoff, TabularGame
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.games.base import AbstractTabularGame
from gsiirl.rewards import attack_graph as rewards
from gsiirl.scenarios.network import AttackNetwork, Variant
from gsiirl.types import Sides
from tests import oracles

HORIZON = 4
DISCOUNT = 0.9


@eqx.filter_jit
def _solve(game: AbstractTabularGame, true: Sides, temperature: jax.Array, discount: float) -> LogitSolution:
    return Logit(temperature).solve(game, true, discount)


def solve(game: AbstractTabularGame, true: Sides, temperature: float, discount: float = DISCOUNT) -> LogitSolution:
    """The logit equilibrium, compiled once for all games of one shape and all temperatures."""
    return _solve(game, true, jnp.asarray(temperature), discount)


def tabular_game(dense: oracles.Game, horizon: int = HORIZON) -> TabularGame:
    """A dense game with every state as a possible successor."""
    states = dense.transition.shape[0]
    successors = np.broadcast_to(np.arange(states), dense.transition.shape)
    return TabularGame.from_arrays((successors, dense.transition), initial=dense.initial, horizon=horizon)


def rewards_of(dense: oracles.Game) -> Sides:
    """Both rewards of a dense game as payoffs."""
    return Sides(DensePayoff(jnp.asarray(dense.learner_reward)), DensePayoff(jnp.asarray(dense.expert_reward)))


def small_network(variant: Variant = "general_sum") -> AttackNetwork:
    """Four nodes in a diamond with a two-way pair, an entry edge, and one foothold."""
    return AttackNetwork(
        name="diamond",
        node_names=("a", "b", "c", "d"),
        value=np.array([0.0, 0.7, 1.2, 0.9]),
        criticality=np.array([0.0, 1.1, 0.4, 1.3]),
        edge_source=np.array([0, 0, 1, 2, 2, -1]),
        edge_target=np.array([1, 2, 3, 3, 1, 2]),
        success_probability=np.array([0.6, 0.8, 0.9, 0.5, 0.7, 0.4]),
        attack_cost=np.array([0.1, 0.2, 0.05, 0.15, 0.1, 0.3]),
        block_cost=np.array([1.0, 0.9, 1.1, 0.8, 1.2, 1.0]),
        footholds=(0,),
    ).with_variant(variant)


def small_attack_graph(
    variant: Variant = "general_sum", no_op: bool = False, horizon: int = HORIZON
) -> tuple[AttackNetwork, AttackGraph, oracles.AttackGraph]:
    """The small network as a game over all its states, and as the oracle's dense arrays."""
    network = small_network(variant)
    game = AttackGraph.create(network, horizon, learner_no_op=no_op, expert_no_op=no_op, starts=range(16))
    return network, game, oracles.attack_graph_dense(network, no_op)


def true_rewards(game: AttackGraph, network: AttackNetwork) -> Sides:
    """r_ld + r_li and r_e of an attack graph."""
    dependent = rewards.commitment_features(game).payoff(jnp.asarray(rewards.dependent_weights(network)))
    expert = rewards.attack_features(game).payoff(jnp.asarray(rewards.expert_weights(network)))
    return Sides(dependent + rewards.own_reward(game, network), expert)


def uniform_policy(game: AbstractTabularGame) -> jax.Array:
    """The learner's policy that picks every action equally often."""
    actions = game.number_of_actions.learner
    return jnp.full((game.horizon, game.number_of_states, actions), 1.0 / actions)
