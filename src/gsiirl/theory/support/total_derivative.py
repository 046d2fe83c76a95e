"""The total derivative d f(θ_l, θ_e*(θ_l)) / dθ_l, exactly, for demonstrations that move with θ_l.

    θ_l → π_l played at (θ_l, θ̄_e) → D: the true expert's response to it → θ_e*(θ_l) → f(θ_l, θ_e*(θ_l))

θ_e* minimises L for infinitely many demonstrations. θ̄_e, the estimate believed when D is collected, is held, as
Algorithm 1 holds it: where r_e can be expressed this moves θ_e* by O(λ) only.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from gsiirl.hypergradients import BilevelProblem, Implicit
from gsiirl.irl.expectations import expected_return
from gsiirl.irl.memory import Memory, Played
from gsiirl.theory.support.games import DISCOUNT, RandomProblem
from gsiirl.theory.support.lower_solution import solve_lower
from gsiirl.types import Number


class Equilibrium(eqx.Module):
    """The forward model at one (θ_l, θ_e): π_l and dπ_l/dθ_l, f with ∇_{θ_l} f and ∇_{θ_e} f."""

    learner_policy: Float[Array, "*b T S A_l"]
    policy_jacobian: Float[Array, "*b T S A_l n"]
    objective: Float[Array, "*b"]
    through_learner: Float[Array, "*b n"]
    through_expert: Float[Array, "*b m"]


@jax.jit
@jax.vmap
def equilibria(
    problem: RandomProblem, commitment: Float[Array, " n"], expert_parameters: Float[Array, " m"]
) -> Equilibrium:
    """Everything that is asked of a solved game, so that one compiled program solves all of them.

    Problems, θ_l and θ_e have a leading axis of N games.
    """
    bilevel = problem.bilevel(0.0)
    size = commitment.shape[0]

    def solved(both: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        policies = bilevel.solve(both[:size], both[size:]).policies
        objective = expected_return(problem.game, bilevel.accessed + bilevel.own_reward, policies, DISCOUNT)
        return (policies.learner, objective), (policies.learner, objective)

    (jacobian, gradient), (learner_policy, objective) = jax.jacfwd(solved, has_aux=True)(
        jnp.concatenate([commitment, expert_parameters])
    )
    return Equilibrium(learner_policy, jacobian[..., :size], objective, gradient[:size], gradient[size:])


def lower_gradient(
    problem: RandomProblem,
    learner_policy: Float[Array, "T S A_l"],
    expert_parameters: Float[Array, " m"],
    regularisation: Number,
) -> Float[Array, " m"]:
    """∇_{θ_e} L for infinitely many demonstrations against π_l."""
    demonstrated = problem.features_met(problem.answered(learner_policy))
    bilevel, memory = problem.bilevel(regularisation), remembered(learner_policy, demonstrated)
    # θ_l enters through the policy alone.
    return bilevel.lower_gradient(jnp.zeros(bilevel.dependent_reward.number_of_parameters), expert_parameters, memory)


def remembered(learner_policy: Float[Array, "T S A_l"], demonstrated: Float[Array, " m"]) -> Memory[Played]:
    """A memory that holds this one interaction."""
    played = Played(learner_policy, demonstrated)
    return Memory.empty(1, played).remember(jax.random.key(0), played)


def minimiser(
    problem: RandomProblem, learner_policy: Float[Array, "T S A_l"], regularisation: Number
) -> Float[Array, " m"]:
    """θ_e* for infinitely many demonstrations against π_l; the search begins at the truth, an O(λ) away."""
    return solve_lower(
        lambda theta: lower_gradient(problem, learner_policy, theta, regularisation), problem.true_parameters
    ).parameters


minimisers = jax.jit(jax.vmap(minimiser, (0, 0, None)))


@jax.jit
def _composed(
    problems: RandomProblem,
    commitments: Float[Array, "N n"],
    played: Equilibrium,
    at_minimiser: Equilibrium,
    expert_parameters: Float[Array, "N m"],
    regularisation: Float[Array, ""],
) -> Float[Array, "N n"]:
    def of_one(problem: RandomProblem, commitment: Array, played: Equilibrium, there: Equilibrium, solution: Array):
        def evaluate(learner: Array, expert: Array) -> tuple[Array, Array]:
            # To first order in θ_l, and that in f's arguments, which is all that a first derivative sees.
            moved = learner - commitment
            objective = jnp.vdot(there.through_learner, moved) + jnp.vdot(there.through_expert, expert)
            policy = played.learner_policy + played.policy_jacobian @ moved
            return objective, lower_gradient(problem, policy, expert, 0.0)

        # The demonstrations move inside `evaluate`: nothing is left to be measured.
        level = BilevelProblem(evaluate, regularisation)
        return Implicit("frozen").hypergradient(level, commitment, solution).value

    return jax.vmap(of_one)(problems, commitments, played, at_minimiser, expert_parameters)


def total_derivatives(
    problems: RandomProblem,
    commitments: Float[Array, "N n"],
    believed: Float[Array, "N m"],
    regularisation: float,
) -> tuple[Float[Array, " N"], Float[Array, "N n"]]:
    """f(θ_l, θ_e*(θ_l)) and its derivative in N games, at θ_l where demonstrations were collected under θ̄_e."""
    played = equilibria(problems, commitments, believed)
    solutions = minimisers(problems, played.learner_policy, regularisation)
    there = equilibria(problems, commitments, solutions)
    return there.objective, _composed(problems, commitments, played, there, solutions, jnp.asarray(regularisation))
