"""The paper's eq. 5-7: one softmax policy over joint actions, for the sum of all rewards.

    Q_t(s, a) = r_l(s, a) + r_e(s, a) + γ E[V_t+1(s')],   V_t = τ logsumexp_a(Q_t / τ),   π_t(a|s) ∝ exp(Q_t / τ)

It is the model in which the paper's lemmas hold to the letter, and the solution of a fully cooperative game. It is no
equilibrium of a general-sum game: where r_l = −r_e the rewards cancel, and both sides act at random.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from gsiirl.equilibria.base import AbstractForwardModel, AbstractSolution
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Number, Policies, Sides


class SoftJointSolution(AbstractSolution):
    """The joint policy (T, S, A_l, A_e), its soft values (T, S), and the two marginals as `policies`.

    The joint policy does not factor into its marginals: both sides follow it together only if they can correlate.
    The recursion is exact, so that the residual is zero.
    """

    joint: Float[Array, "T S A_l A_e"]
    values: Float[Array, "T S"]
    policies: Policies
    residual: Float[Array, ""]
    converged: Bool[Array, ""]


class SoftJoint(AbstractForwardModel):
    """Solver of eq. 5-7; `temperature` is τ in reward units."""

    temperature: float | Float[Array, ""]

    def solve(self, game: AbstractTabularGame, rewards: Sides[AbstractPayoff], discount: Number) -> SoftJointSolution:
        dtype = game.initial.dtype
        temperature = jnp.asarray(self.temperature, dtype)
        total = rewards.learner + rewards.expert

        def backward(values, _):
            scaled = (total + game.continuation(values) * discount).dense() / temperature
            soft = jax.nn.logsumexp(scaled, axis=(-2, -1))
            return temperature * soft, (jnp.exp(scaled - soft[:, None, None]), temperature * soft)

        _, (joint, values) = jax.lax.scan(
            backward, jnp.zeros_like(game.initial), None, length=game.horizon, reverse=True
        )
        return SoftJointSolution(
            joint=joint,
            values=values,
            policies=Sides(jnp.sum(joint, axis=-1), jnp.sum(joint, axis=-2)),
            residual=jnp.zeros((), dtype),
            converged=jnp.asarray(True),
        )


def joint_occupancy(
    game: AbstractTabularGame, joint: Float[Array, "T S A_l A_e"], discount: float
) -> Float[Array, "T S A_l A_e"]:
    """γ^t P(s_t = s, a_t = a) under a joint policy."""

    def forward(distribution, joint_now):
        mass = distribution[:, None, None] * joint_now
        # Mass flows forward by the transpose of how values flow back.
        (following,) = jax.linear_transpose(lambda values: game.continuation(values).dense(), distribution)(mass)
        return following, mass

    _, masses = jax.lax.scan(forward, game.initial, joint)
    return (discount ** jnp.arange(game.horizon, dtype=masses.dtype))[:, None, None, None] * masses
