"""Peak memory of one exact hypergradient at T = 512 on 256 states: measured by running this module.

The peak of a process never falls, so it is measured in a process of its own.
"""

import json
import resource
import sys

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.bilevel import Bilevel
from gsiirl.equilibria.logit import Logit
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.hypergradients import Implicit
from gsiirl.rewards import attack_graph as rewards
from gsiirl.rewards.linear import Linear
from gsiirl.scenarios import random_network
from gsiirl.types import Sides

NODES, EDGES, HORIZON = 8, 10, 512


def attack_graph_bilevel(horizon: int) -> tuple[Bilevel, Sides[Float[Array, " k"]]]:
    """Both levels on a random attack graph with all 256 states, as a run of `security` has them, and (θ_l, θ_e)."""
    network = random_network(0, NODES, EDGES, "general_sum")
    game = AttackGraph.create(network, horizon, starts=range(2**NODES))
    commitment, attack = rewards.commitment_features(game), rewards.attack_features(game)
    scale = 1.5 * len(attack.names) ** 0.5
    dependent = Linear(commitment, scale)
    bilevel = Bilevel(
        game=game,
        own_reward=rewards.own_reward(game, network),
        accessed=commitment.payoff(jnp.asarray(rewards.dependent_weights(network))),
        dependent_reward=dependent,
        expert_reward=Linear(attack, scale),
        forward_model=Logit(0.4),
        temperature=0.4,
        discount=0.95,
        regularisation=1e-3,
    )
    random = np.random.default_rng(0)
    directions = (random.normal(size=len(features.names)) for features in (commitment, attack))
    return bilevel, Sides(*(jnp.asarray(0.5 * each / np.linalg.norm(each)) for each in directions))


def peak_bytes() -> int:
    """The most memory this process has held so far."""
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return used if sys.platform == "darwin" else 1024 * used


def main() -> None:
    """Print the peak before and after the hypergradient, in bytes, as JSON."""
    with jax.enable_x64(True):
        bilevel, point = attack_graph_bilevel(HORIZON)
        # What was demonstrated does not enter a hypergradient that holds it, but for whether the ball is active.
        problem = bilevel.problem(point.expert, jnp.zeros_like(point.expert))
        estimator = Implicit("frozen")

        def hypergradient(commitment: Array, expert_parameters: Array) -> Array:
            found, _ = estimator.estimate(
                problem, commitment, expert_parameters, None, jax.random.key(0), jnp.asarray(0)
            )
            return found.value

        compiled = jax.jit(hypergradient).lower(point.learner, point.expert).compile()
        before = peak_bytes()
        finite = bool(jnp.all(jnp.isfinite(compiled(point.learner, point.expert))))
    print(json.dumps({"before": before, "after": peak_bytes(), "finite": finite}))


if __name__ == "__main__":
    main()
