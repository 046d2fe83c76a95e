"""A result beside its yardsticks, with the true reward (`Result.evaluate`)."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from gsiirl.commitment.objective import Commitment
from gsiirl.compilation import QUICKLY
from gsiirl.evaluation.commitment import SHARPER, Extremes, Marl, equilibrium, extremes
from gsiirl.games.base import uniform_policy
from gsiirl.games.payoff import AbstractPayoff
from gsiirl.problems.problem import Problem

LAST = 10
"""Iterations at the end of a run whose play is averaged."""


@dataclass(frozen=True, repr=False)
class AbstractEvaluation(Mapping[str, Any]):
    """A record of numbers that is also a mapping of their names."""

    def __getitem__(self, name: str) -> Any:
        if name not in set(self):
            raise KeyError(name)
        return getattr(self, name)

    def __iter__(self) -> Iterator[str]:
        return (each.name for each in fields(self))

    def __len__(self) -> int:
        return len(fields(self))

    def __repr__(self) -> str:
        numbers = ", ".join(f"{name}={self[name]:.4g}" for name in self if isinstance(self[name], float))
        return f"{type(self).__name__}({numbers})"


@dataclass(frozen=True, repr=False)
class Evaluation(AbstractEvaluation):
    """The learner's returns against the true expert; discounted, and under `undiscounted` without discount.

    `deployed` is what the result's policy earns, `played` what the policies of the last ten iterations earned while
    learning (mean), `best_played` the most that any policy played earned, `random` uniform play; `ceiling` and `floor`
    the best and the worst commitment that a search with the true reward finds; `marl` and `sharp_marl` the equilibria
    of both true rewards, with a learner as soft as the expert and one thirty times sharper. `regret` is
    (ceiling − deployed) / (ceiling − floor). All but `regret` are in units of the reward.

    `undiscounted` holds `deployed`, `ceiling`, `random`, `marl`, `sharp_marl` and `played`; `ceiling_policy` is
    (T, S, A_l). Where no played policies were kept (results that are loaded from run folders), `played` is NaN and
    `best_played` −inf.
    """

    deployed: float
    played: float
    best_played: float
    ceiling: float
    floor: float
    regret: float
    random: float
    marl: float
    sharp_marl: float
    marl_converged: bool
    sharp_marl_converged: bool
    undiscounted: dict[str, float]
    ceiling_policy: np.ndarray


def evaluate(
    problem: Problem,
    policy: np.ndarray,
    played: np.ndarray,
    expert_reward: AbstractPayoff,
    temperature: float,
    seed: int,
) -> Evaluation:
    """Every yardstick of a finite game in one record; `played` are the policies of the last iterations."""
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        commitment = Commitment(problem.game, problem.own_reward + problem.dependent_value, problem.discount)
        commitment, reward, tau = jax.tree.map(jnp.asarray, (commitment, expert_reward, temperature))
        found = _extremes(commitment, reward, tau, jnp.asarray(policy)[None], jax.random.key(seed))
        sharpness = {"marl": 1.0, "sharp_marl": SHARPER}
        solved = {name: _equilibrium(commitment, reward, tau, jnp.asarray(each)) for name, each in sharpness.items()}
        policies = {
            "deployed": jnp.asarray(policy),
            "ceiling": found.best,
            "random": uniform_policy(problem.game),
            **{name: each.policy for name, each in solved.items()},
        }
        every = jnp.concatenate([jnp.stack(list(policies.values())), jnp.asarray(played)])
        values, undiscounted = (np.asarray(each) for each in _returns(commitment, reward, tau, every))

    def mean(each: np.ndarray) -> float:
        # A run folder keeps none of the policies that were played.
        return float(each.mean()) if each.size else float("nan")

    earned = dict(zip(policies, values.tolist(), strict=False))
    plain = dict(zip(policies, undiscounted.tolist(), strict=False))
    ceiling, floor = max(float(found.ceiling), earned["deployed"]), min(float(found.floor), earned["deployed"])
    span = ceiling - floor
    return Evaluation(
        deployed=earned["deployed"],
        played=mean(values[len(policies) :][-LAST:]),
        best_played=float(np.max(values[len(policies) :], initial=-np.inf)),
        ceiling=ceiling,
        floor=floor,
        # Where every commitment earns the same there is nothing to regret.
        regret=(ceiling - earned["deployed"]) / span if span > 1e-12 * max(1.0, abs(ceiling)) else 0.0,
        random=earned["random"],
        marl=earned["marl"],
        sharp_marl=earned["sharp_marl"],
        marl_converged=bool(solved["marl"].converged),
        sharp_marl_converged=bool(solved["sharp_marl"].converged),
        undiscounted={**plain, "played": mean(undiscounted[len(policies) :][-LAST:])},
        ceiling_policy=np.asarray(found.best),
    )


@partial(jax.jit, compiler_options=QUICKLY)
def _extremes(commitment: Commitment, reward: AbstractPayoff, temperature: Array, also: Array, key: Array) -> Extremes:
    return extremes(commitment, reward, temperature, also, key)


@partial(jax.jit, compiler_options=QUICKLY)
def _equilibrium(commitment: Commitment, reward: AbstractPayoff, temperature: Array, sharper: Array) -> Marl:
    return equilibrium(commitment, reward, temperature, sharper)


@jax.jit
def _returns(
    commitment: Commitment, reward: AbstractPayoff, temperature: Array, policies: Array
) -> tuple[Array, Array]:
    one = jnp.ones((), policies.dtype)

    def both(policy: Array) -> tuple[Array, Array]:
        return (
            commitment.value(policy, reward, temperature),
            commitment.value(policy, reward, temperature, discount=one),
        )

    return jax.vmap(both)(policies)
