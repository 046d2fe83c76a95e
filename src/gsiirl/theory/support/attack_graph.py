"""A bilevel problem of a size that runs have: a random attack graph with all of its 256 states."""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.bilevel import Bilevel
from gsiirl.equilibria.logit import Logit
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.rewards import attack_graph as rewards
from gsiirl.rewards.linear import Linear
from gsiirl.scenarios import random_network
from gsiirl.theory.support.games import of_norm

NODES, EDGES = 8, 10


def attack_graph_bilevel(horizon: int) -> tuple[Bilevel, tuple[Float[Array, " n"], Float[Array, " m"]]]:
    """Both levels, as a run of `security` has them, and a point (θ_l, θ_e)."""
    network = random_network(0, NODES, EDGES, "general_sum")
    game = AttackGraph.create(network, horizon, starts=range(2**NODES))
    commitment, attack = rewards.commitment_features(game), rewards.attack_features(game)
    scale = 1.5 * len(attack.names) ** 0.5
    bilevel = Bilevel(
        game=game,
        own_reward=rewards.own_reward(game, network),
        accessed=commitment.payoff(jnp.asarray(rewards.dependent_weights(network))),
        dependent_reward=Linear(commitment, scale),
        expert_reward=Linear(attack, scale),
        forward_model=Logit(0.4),
        temperature=0.4,
        discount=0.95,
    )
    random = np.random.default_rng(0)
    return bilevel, (of_norm(random, 0.5, len(commitment.names)), of_norm(random, 0.5, len(attack.names)))
