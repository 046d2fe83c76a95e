"""The entropy-regularised Markov logit equilibrium of a tabular game, explained in docs/equilibria.md.

Backward in t, from V_T = 0, for both sides i:

    Q_i,t(s, a) = r_i(s, a) + γ E[V_i,t+1(s')]
    π_i,t(a_i|s) ∝ exp(E_{a_-i ~ π_-i} Q_i,t(s, a) / τ)
    V_i,t(s) = τ logsumexp_{a_i}(E_{a_-i ~ π_-i} Q_i,t(s, a) / τ)

over the actions that each side may choose; V_i is 0 in terminal states.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from gsiirl.equilibria.base import AbstractForwardModel, AbstractSolution
from gsiirl.equilibria.stage.solve import differentiable_log_policies, solve_stage
from gsiirl.games.base import AbstractTabularGame, only_allowed
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Number, Policies, Sides


class LogitSolution(AbstractSolution):
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


class Logit(AbstractForwardModel):
    """Solver of the Markov logit equilibrium.

    Differentiable in rewards and temperature by the implicit function theorem. `temperature` is τ in reward units. The
    residual of a stage game is brought below 2000 ε (1 + max |Q| / 100 τ), ε being the precision of the game's
    arrays: about what rounding in Q/τ leaves.
    """

    temperature: float | Float[Array, ""]

    def solve(self, game: AbstractTabularGame, rewards: Sides[AbstractPayoff], discount: Number) -> LogitSolution:
        """The equilibrium of `game` under `rewards` (payoffs over all states)."""
        dtype = game.initial.dtype
        temperature = jnp.asarray(self.temperature, dtype)
        allowed = game.allowed
        stage = jax.vmap(
            lambda q, guess, tolerance, allowed: solve_stage(q, temperature, guess, tolerance, allowed),
            (0, 0, None, 0),
        )
        implicit = jax.vmap(lambda q, found, allowed: differentiable_log_policies(q, temperature, found, allowed))

        def backward(carry, _):
            values, guess = carry
            following = jax.tree.map(game.continuation, values)
            payoffs = Sides(
                rewards.learner + following.learner * discount, rewards.expert + following.expert * discount
            )
            largest = jnp.max(jnp.stack([jnp.max(jnp.abs(leaf)) for leaf in jax.tree.leaves(payoffs)]))
            tolerance = jax.lax.stop_gradient(2e3 * jnp.finfo(dtype).eps * (1.0 + 0.01 * largest / temperature))
            found = stage(jax.lax.stop_gradient(payoffs), jax.lax.stop_gradient(guess), tolerance, allowed)
            converged = jnp.all(found.residual <= 10.0 * tolerance)
            log_policies = implicit(payoffs, found.log_policies, allowed)
            policies = jax.tree.map(jnp.exp, log_policies)
            scaled = Sides(
                only_allowed(payoffs.learner.learner_values(policies.expert) / temperature, allowed.learner),
                only_allowed(payoffs.expert.expert_values(policies.learner) / temperature, allowed.expert),
            )
            values = jax.tree.map(lambda each: game.alive(temperature * jax.nn.logsumexp(each, axis=-1)), scaled)
            return (values, log_policies), (policies, values, found, converged)

        nothing = jnp.zeros_like(game.initial)
        uniform = jax.tree.map(
            lambda actions: jnp.full((game.number_of_states, actions), -jnp.log(actions), dtype), game.number_of_actions
        )
        _, (policies, values, found, converged) = jax.lax.scan(
            backward, (Sides(nothing, nothing), uniform), None, length=game.horizon, reverse=True
        )
        return LogitSolution(
            policies=policies,
            values=values,
            residual=jnp.max(found.residual),
            converged=jnp.all(converged),
            branch_folds=found.branch_folds,
            followed=found.followed,
        )
