"""Yardsticks of a committed policy under the true rewards; no learner holds any of this.

ceiling   the most that any commitment found by the search earns, with r_e known
floor     the least
regret    (ceiling − deployed) / (ceiling − floor), in discounted returns
MARL      the logit equilibrium of both true rewards, at the expert's temperature (soft), and with a learner whose
          temperature is a thirtieth of that (sharp)
"""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from gsiirl.commitment.objective import Commitment
from gsiirl.commitment.search import Search, Starts, committed, is_small, logits_of
from gsiirl.equilibria.logit import Logit
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.types import Sides

SHARPER = 30.0
"""How many times sharper than the expert the learner of sharp MARL is."""


class Extremes(eqx.Module):
    """The best and the worst commitment found: policies (T, S, A_l), and their discounted returns."""

    best: Float[Array, "T S A_l"]
    ceiling: Float[Array, ""]
    floor: Float[Array, ""]


class Marl(eqx.Module):
    """An equilibrium's learner policy (T, S, A_l), and whether the solver converged."""

    policy: Float[Array, "T S A_l"]
    converged: Bool[Array, ""]


def extremes(
    commitment: Commitment,
    expert_reward: AbstractPayoff,
    temperature: float | Float[Array, ""],
    also: Float[Array, "N T S A_l"],
    key: PRNGKeyArray,
) -> Extremes:
    """The ceiling and the floor of f; `also` are policies that the search for the ceiling starts from as well."""
    game = commitment.game
    small = is_small(game)
    search = Search(game, steps=100)
    unit = expert_reward * (1.0 / jnp.asarray(temperature, game.initial.dtype))
    spread = commitment.range_of_answers(unit)
    number = 32 if small else 12
    best_key, worst_key, start_key = jax.random.split(key, 3)
    nothing = jnp.zeros(0, game.initial.dtype)
    starts = search.random(number, spread, start_key)
    best = committed(commitment, lambda _: unit)
    logits, values = search.best(
        best, starts.and_also(Starts.plain(logits_of(also))), nothing, 12 if small else 4, best_key
    )
    worst = committed(Commitment(game, -commitment.learner_reward, commitment.discount), lambda _: unit)
    _, losses = search.best(worst, starts, nothing, 4 if small else 1, worst_key)
    return Extremes(commitment.policy(logits[0]), values[0], -losses[0])


def equilibrium(
    commitment: Commitment,
    expert_reward: AbstractPayoff,
    temperature: float | Float[Array, ""],
    sharper: float | Float[Array, ""],
) -> Marl:
    """The learner's half of the logit equilibrium in which the learner is `sharper` times sharper than the expert."""
    rewards = Sides(commitment.learner_reward * sharper, expert_reward)
    solution = Logit(temperature).solve(commitment.game, rewards, commitment.discount)
    return Marl(solution.policies.learner, solution.converged)
