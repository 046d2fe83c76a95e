"""The entropy-regularised Markov logit equilibrium of a tabular game (spec section 3).

Backward in t, from V_T = 0, for both sides i:

    Q_i,t(s, a) = r_i(s, a) + γ E[V_i,t+1(s')]
    π_i,t(a_i|s) ∝ exp(E_{a_-i ~ π_-i} Q_i,t(s, a) / τ)
    V_i,t(s) = τ logsumexp_{a_i}(E_{a_-i ~ π_-i} Q_i,t(s, a) / τ)
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from gsiirl.equilibria.stage import differentiable_log_policies, solve_stage
from gsiirl.games.base import AbstractTabularGame
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Policies, Sides


class LogitSolution(eqx.Module):
    """A joint policy with the quality of the solve.

    `policies` and `values` are time-indexed, (T, S, A) and (T, S); `residual` is max |ln π_i − log_softmax(E Q_i / τ)|
    over everything; `branch_folds` and `followed` (T, S) are those of the stage games (see `StageSolution`).
    """

    policies: Policies
    values: Sides[Float[Array, "T S"]]
    residual: Float[Array, ""]
    converged: Bool[Array, ""]
    branch_folds: Bool[Array, "T S"]
    followed: Bool[Array, "T S"]


class Logit(eqx.Module):
    """Solver of the Markov logit equilibrium.

    Differentiable in rewards and temperature by the implicit function theorem. `temperature` is τ in reward units;
    `tolerance` bounds the residual of every stage game (None: what the precision of the rewards allows).
    """

    temperature: float | Float[Array, ""]
    tolerance: float | None = eqx.field(static=True, default=None)

    def solve(self, game: AbstractTabularGame, rewards: Sides[AbstractPayoff], discount: float) -> LogitSolution:
        """The equilibrium of `game` under `rewards` (payoffs over all states)."""
        dtype = game.initial.dtype
        tolerance = self.tolerance if self.tolerance is not None else 2e3 * float(jnp.finfo(dtype).eps)
        temperature = jnp.asarray(self.temperature, dtype)
        stage = jax.vmap(lambda q, guess: solve_stage(q, temperature, guess, tolerance))
        implicit = jax.vmap(lambda q, found: differentiable_log_policies(q, temperature, found))

        def backward(carry, _):
            values, guess = carry
            following = jax.tree.map(game.continuation, values)
            payoffs = Sides(
                rewards.learner + following.learner * discount, rewards.expert + following.expert * discount
            )
            found = stage(jax.lax.stop_gradient(payoffs), jax.lax.stop_gradient(guess))
            log_policies = implicit(payoffs, found.log_policies)
            policies = jax.tree.map(jnp.exp, log_policies)
            values = Sides(
                temperature * jax.nn.logsumexp(payoffs.learner.learner_values(policies.expert) / temperature, axis=-1),
                temperature * jax.nn.logsumexp(payoffs.expert.expert_values(policies.learner) / temperature, axis=-1),
            )
            return (values, log_policies), (policies, values, found.residual, found.branch_folds, found.followed)

        nothing = jnp.zeros_like(game.initial)
        uniform = jax.tree.map(
            lambda actions: jnp.full((game.number_of_states, actions), -jnp.log(actions), dtype), game.number_of_actions
        )
        _, (policies, values, residual, folds, followed) = jax.lax.scan(
            backward, (Sides(nothing, nothing), uniform), None, length=game.horizon, reverse=True
        )
        worst = jnp.max(residual)
        return LogitSolution(policies, values, worst, worst <= 10 * tolerance, folds, followed)
