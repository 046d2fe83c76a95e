"""Which directions of the expert's reward no answer of the expert can show.

A direction v of the weights is unseen where the response to every policy of the learner is the same under θ and θ + v.
In games of one step r(a_l, a_e) + c(a_l) is such a reward for every c; in a network whose attacker must attack, a
common constant in all costs is one. Unseen are the v with v' F v = 0, F the Fisher information of answers to many
policies in all states at all times.
"""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from gsiirl.compilation import QUICKLY
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
    if likelihood.number_of_weights > DENSE:
        return jnp.zeros((likelihood.number_of_weights, 0))
    sizes, directions = np.linalg.eigh(np.asarray(_information(jax.tree.map(jnp.asarray, likelihood))))
    return jnp.asarray(directions[:, sizes <= UNSEEN * sizes[-1]])


@partial(jax.jit, compiler_options=QUICKLY)
def _information(likelihood: ConditionalLikelihood) -> Float[Array, "m m"]:
    """F of answers to the uniform policy and to `POLICIES` random ones, each met once in every state at every time."""
    game = likelihood.game
    uniform = uniform_policy(game)
    key = jax.random.key(0)
    # Sharp policies, so that what differs between the learner's actions is seen.
    logits = 3.0 * jax.random.normal(key, (POLICIES, *uniform.shape), uniform.dtype)
    played = jnp.concatenate([uniform[None], jax.vmap(lambda each: learner_policy(game, each))(logits)])
    actions = game.number_of_actions.expert
    once = jnp.full((len(played), *uniform.shape[:2], actions), 1.0 / actions, uniform.dtype)
    memory = Memory(Seen(played, once), jnp.asarray(len(played), jnp.int32))
    weights = jax.random.normal(jax.random.key(1), (likelihood.number_of_weights,), uniform.dtype)
    return likelihood.fisher(weights, memory)
