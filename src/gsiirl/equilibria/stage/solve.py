"""The logit equilibrium of one stage game, on the principal branch.

Two methods share one linear system, solved by elimination of what couples pairs of actions (`solve_coupled`) and a
small border: two multipliers that keep the policies normalised and, along a path, the step in λ.

- `newton`: damped Newton at the target λ. It is used alone only where `certified_unique` proves that one equilibrium
  exists, so that it cannot find a wrong one.
- `follow_branch`: continuation from the uniform policies at λ = 0 up to the first crossing of the target λ; a branch
  that turns back on the way is flagged.

Every function takes one stage game; `vmap` is outside.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from gsiirl.equilibria.stage.branch import follow_branch
from gsiirl.equilibria.stage.equations import ALL, Allowed, best_response, masked, residual_of
from gsiirl.equilibria.stage.newton import newton, newton_direction
from gsiirl.equilibria.stage.unique import certified_unique
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides


class StageSolution(eqx.Module):
    """Log-policies of a stage game, with how they were found.

    `residual` is max |R| over both sides; `branch_folds` says that the principal branch turned back in λ before the
    target; `followed` that it was followed at all (not needed where the equilibrium is provably unique).
    """

    log_policies: Sides[Float[Array, " A"]]
    residual: Float[Array, ""]
    branch_folds: Bool[Array, ""]
    followed: Bool[Array, ""]


@jax.jit
def solve_stage(
    payoffs: Sides[AbstractPayoff],
    temperature: Float[Array, ""],
    guess: Sides[Float[Array, " A"]],
    tolerance: float | Float[Array, ""],
    allowed: Allowed = ALL,
) -> StageSolution:
    """The principal logit equilibrium of one stage game; `guess` are log-policies to start Newton's method from.

    `allowed` says which actions each side may choose, None being all. Not differentiable: see
    `differentiable_log_policies`.
    """
    target = 1.0 / temperature
    start = best_response(payoffs, jax.tree.map(jnp.exp, guess), target, allowed)
    certified = certified_unique(payoffs, target) if not masked(allowed) else jnp.asarray(False)
    tried = newton(payoffs, target, start, tolerance, certified, allowed)
    unsolved = ~(certified & (tried.size <= tolerance))
    branch = follow_branch(payoffs, target, unsolved, allowed)
    log_policies = jax.tree.map(lambda a, b: jnp.where(unsolved, a, b), branch.point.log_policies, tried.log_policies)
    polished = newton(payoffs, target, log_policies, tolerance, unsolved, allowed)
    return StageSolution(
        log_policies=polished.log_policies,
        residual=jnp.where(unsolved & ~branch.arrived, jnp.inf, polished.size),
        branch_folds=branch.folds,
        followed=unsolved,
    )


@jax.jit
def differentiable_log_policies(
    payoffs: Sides[AbstractPayoff],
    temperature: Float[Array, ""],
    log_policies: Sides[Float[Array, " A"]],
    allowed: Allowed = ALL,
) -> Sides[Float[Array, " A"]]:
    """The solution as a function of payoffs and temperature, by the implicit function theorem.

    One Newton step from the solution w*: w* − J⁻¹ R(w*; payoffs, τ) with J and w* held fixed. Its value is w*, its
    first derivative is −J⁻¹ ∂R, in forward and in reverse mode.
    """
    frozen = jax.lax.stop_gradient(log_policies)
    residual = residual_of(payoffs, frozen, 1.0 / temperature, allowed)
    held = jax.lax.stop_gradient(payoffs)
    step = newton_direction(held, frozen, jax.lax.stop_gradient(1.0 / temperature), residual)
    return jax.tree.map(jnp.add, frozen, step)
