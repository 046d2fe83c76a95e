"""Which directions of the expert's reward no answer of the expert can show.

A direction v of the weights is unseen where the response to every policy of the learner is the same under θ and θ + v.
In games of one step r(a_l, a_e) + c(a_l) is such a reward for every c; in a network whose attacker must attack, a
common constant in all costs is one. Unseen are the v with v' F v = 0, F the Fisher information of answers to many
policies in all states at all times.
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.games.base import learner_policy, uniform_policy
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood, Seen
from gsiirl.irl.memory import Memory
from gsiirl.limits import DENSE

POLICIES = 8
"""Random policies of the learner that are asked, beside the uniform one."""
UNSEEN = 1e-10
"""Share of the largest eigenvalue of F up to which one counts as 0."""


def unseen_directions(likelihood: ConditionalLikelihood) -> Float[Array, "m k"]:
    """An orthonormal basis of the unseen directions; none where there are too many weights for a matrix."""
    m, game = likelihood.number_of_weights, likelihood.game
    if m > DENSE:
        return jnp.zeros((m, 0))
    uniform = uniform_policy(game)
    keys = jax.random.split(jax.random.key(0), POLICIES)
    # Sharp policies, so that what differs between the learner's actions is seen.
    logits = [3.0 * jax.random.normal(key, uniform.shape, uniform.dtype) for key in keys]
    once = jnp.full((*uniform.shape[:2], game.number_of_actions.expert), 1.0 / game.number_of_actions.expert)
    memory = Memory.empty(POLICIES + 1, Seen(uniform, once)).remember(keys[0], Seen(uniform, once))
    for key, each in zip(keys, logits, strict=True):
        memory = memory.remember(key, Seen(learner_policy(game, each), once))
    weights = jax.random.normal(jax.random.key(1), (m,), uniform.dtype)
    information = np.asarray(_fisher(jax.tree.map(jnp.asarray, likelihood), weights, memory))
    sizes, directions = np.linalg.eigh(information)
    return jnp.asarray(directions[:, sizes <= UNSEEN * sizes[-1]])


@jax.jit
def _fisher(likelihood: ConditionalLikelihood, weights: Array, memory: Memory[Seen]) -> Float[Array, "m m"]:
    return likelihood.fisher(weights, memory)
