"""Algorithm 1 on random games side by side, with the learner, the expert and the loop that runs use.

The learner is `RewardGSIIRL` with the schedules of Theorem 2: plain ascent on θ_l, and t_k = ⌈(k + 1)^(1/4)/2⌉ plain
steps of size 1/L_L on θ_e. Both learn from the newest demonstrations alone.
"""

import functools
from dataclasses import dataclass

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float, Key, PRNGKeyArray, PyTree

from gsiirl.experts.tabular_expert import RespondingExpert
from gsiirl.hypergradients import AbstractEstimator, Implicit
from gsiirl.interaction import AbstractExpert, AbstractLearner, Meeting, Proposal, interact
from gsiirl.irl.maximum_likelihood import MaximumLikelihood, growing_steps
from gsiirl.irl.memory import Played
from gsiirl.learners.reward_learner import RewardGSIIRL, RewardLearnerState
from gsiirl.theory.support.games import DISCOUNT, TEMPERATURE, RandomProblem, Size
from gsiirl.theory.support.total_derivative import equilibria, lower_gradient
from gsiirl.types import Interaction, Number

SIZE = Size(states=3, learner_actions=2, expert_actions=2, horizon=3, learner_parameters=3, expert_parameters=2)
GAMES = 10
CHUNK = 25
"""Iterations compiled into one call; runs are as long as several such."""
WELL_SPECIFIED = Implicit("well_specified")


class ExactExpert(AbstractExpert[None]):
    """The responding expert, seen in infinitely many demonstrations: an interaction holds their μ̂_e (m,) itself."""

    problem: RandomProblem

    def init(self, key: PRNGKeyArray, learner_policy: PyTree) -> None:
        return None

    def meet(self, habits: None, proposal: Proposal, number: int, key: PRNGKeyArray) -> tuple[None, Interaction]:
        demonstrated = self.problem.features_met(self.problem.answered(proposal.policy))
        return None, Interaction(proposal.policy, demonstrated)


class ExactLearner(AbstractLearner[RewardLearnerState]):
    """The learner, told μ̂_e by an `ExactExpert` instead of estimating it from episodes; it reads no values of r_ld."""

    learner: RewardGSIIRL

    def init(self, key: PRNGKeyArray) -> RewardLearnerState:
        return self.learner.init(key)

    def propose(self, state: RewardLearnerState) -> Proposal:
        return self.learner.propose(state)

    def update(self, state: RewardLearnerState, interaction: Interaction, key: PRNGKeyArray) -> RewardLearnerState:
        played = Played(interaction.learner_policy, interaction.demonstrations)
        return self.learner.learn(state, played, state.accessed, key)


@dataclass(frozen=True)
class Games:
    """N random games side by side, where their runs begin, and how smooth both levels are.

    `problems` has a leading axis of games; `commitments` θ_l(0) and `estimates` θ_e(0) are uniform in the unit ball.
    `upper_smoothness` L_f and `lower_smoothness` (L_L without λ) are the largest norms of Hessians of f, at the true
    r_e, and of L, met at random points.
    """

    problems: RandomProblem
    commitments: Float[Array, "N n"]
    estimates: Float[Array, "N m"]
    upper_smoothness: Float[Array, " N"]
    lower_smoothness: Float[Array, " N"]


@functools.cache
def draw_games(number: int = GAMES, points: int = 12) -> Games:
    """The games of seeds 0, 1, …, chosen before anything was measured."""
    problems = jax.tree.map(lambda *each: jnp.stack(each), *(RandomProblem.draw(seed, SIZE) for seed in range(number)))
    random = np.random.default_rng(0)

    def points_of_both() -> tuple[Float[Array, "N n"], Float[Array, "N m"]]:
        learner = uniform_in_ball(random, number, SIZE.learner_parameters)
        return learner, uniform_in_ball(random, number, SIZE.expert_parameters)

    commitments, estimates = points_of_both()
    found = [_curvatures(problems, *points_of_both()) for _ in range(points)]
    upper, lower = np.max(found, axis=0)
    return Games(problems, commitments, estimates, jnp.asarray(upper), jnp.asarray(lower))


def uniform_in_ball(random: np.random.Generator, number: int, size: int) -> Float[Array, "N k"]:
    """`number` points uniform in the unit ball of R^k."""
    directions = random.normal(size=(number, size))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return jnp.asarray(directions * random.uniform(size=(number, 1)) ** (1.0 / size))


_lower_hessians = jax.jit(jax.vmap(jax.jacfwd(lower_gradient, 2), (0, 0, 0, None)))


def _curvatures(
    problems: RandomProblem, commitments: Float[Array, "N n"], believed: Float[Array, "N m"], reach: float = 1e-4
) -> Float[np.ndarray, "2 N"]:
    """Norms of ∇²_{θ_l} f at the true r_e and of ∇²_{θ_e} L at θ̄_e, without λ.

    That of f by central differences of ∇f: the solver's second derivatives are not exact.
    """

    def gradients(shift: Array) -> Array:
        return equilibria(problems, commitments + shift[None, :], problems.true_parameters).through_learner

    moves = reach * jnp.eye(commitments.shape[1])
    upper = jnp.stack([(gradients(move) - gradients(-move)) / (2.0 * reach) for move in moves], axis=2)
    played = equilibria(problems, commitments, believed).learner_policy
    hessians = 0.5 * (upper + upper.swapaxes(1, 2)), _lower_hessians(problems, played, believed, 0.0)
    return np.stack([np.linalg.norm(each, 2, axis=(1, 2)) for each in hessians])


@dataclass(frozen=True)
class Run:
    """K iterations in N games: θ_l(k) as `commitments`, θ_e(k) for k = 0, …, K as `estimates`."""

    commitments: Float[Array, "K N n"]
    estimates: Float[Array, "K+1 N m"]


def algorithm_1(
    games: Games,
    steps: Float[Array, " N"],
    iterations: int,
    regularisation: float,
    hypergradient: AbstractEstimator = WELL_SPECIFIED,
    trajectories: int | None = None,
) -> Run:
    """Algorithm 1 with `steps` α on θ_l in all iterations; as many `trajectories` an iteration, or None for exact ones.

    Raises:
        ValueError: `iterations` is no multiple of `CHUNK`.
    """
    if iterations % CHUNK:
        raise ValueError(f"iterations must be a multiple of {CHUNK}, got {iterations}")
    rates = 1.0 / (games.lower_smoothness + regularisation)
    sizes, keys = (steps, rates, jnp.asarray(regularisation)), jax.random.split(jax.random.key(1), steps.shape[0])
    states = jax.vmap(lambda problem, key: learner_of(problem, 1.0, 1.0, 1.0, hypergradient).init(key))(
        games.problems, keys
    )
    begin = games.commitments, games.estimates
    states = eqx.tree_at(lambda at: (at.commitment, at.expert_parameters), states, begin)
    records = []
    for first in range(0, iterations, CHUNK):
        states, record = _rounds(
            games.problems, states, sizes, hypergradient, keys, jnp.asarray(first), trajectories=trajectories
        )
        records.append(record)
    commitments, estimates = (jnp.concatenate(each) for each in zip(*records, strict=True))
    return Run(commitments, jnp.concatenate([estimates, states.expert_parameters[None]]))


def learner_of(
    problem: RandomProblem, step: Number, rate: Number, regularisation: Number, hypergradient: AbstractEstimator
) -> RewardGSIIRL:
    """The learner of a game, with steps α = `step` on θ_l and `rate` = 1/L_L on θ_e."""
    return RewardGSIIRL(
        bilevel=problem.bilevel(regularisation),
        # Its steps are on τ∇L.
        inner_loop=MaximumLikelihood(TEMPERATURE, growing_steps, optax.sgd(rate / TEMPERATURE)),
        hypergradient=hypergradient,
        ridge=regularisation,
        optimiser=optax.sgd(step),
        remembered=1,
        honest_start=False,
    )


@eqx.filter_jit
def _rounds(
    problems: RandomProblem,
    states: RewardLearnerState,
    sizes: tuple[Float[Array, " N"], Float[Array, " N"], Float[Array, ""]],
    hypergradient: AbstractEstimator,
    keys: Key[Array, " N"],
    first: Array,
    trajectories: int | None,
) -> tuple[RewardLearnerState, tuple[Float[Array, "K N n"], Float[Array, "K N m"]]]:
    """`CHUNK` rounds in every game, with θ_l(k) and θ_e(k) of each."""

    def observe(met: Meeting[RewardLearnerState, None]) -> dict[str, Array]:
        return {"commitment": met.state.commitment, "estimate": met.state.expert_parameters}

    def of_game(problem: RandomProblem, state: RewardLearnerState, step: Array, rate: Array, key: Array):
        learner = learner_of(problem, step, rate, sizes[2], hypergradient)
        if trajectories is None:
            met = ExactLearner(learner), ExactExpert(problem)
        else:
            met = learner, RespondingExpert(problem.game, problem.true_expert_reward(), TEMPERATURE, DISCOUNT)
        (after, _), record = interact(*met, (state, None), key, first, CHUNK, trajectories or 0, observe)
        return after, record

    after, record = jax.vmap(of_game, (0, 0, 0, 0, 0), (0, 1))(problems, states, *sizes[:2], keys)
    return after, (record["commitment"], record["estimate"])
