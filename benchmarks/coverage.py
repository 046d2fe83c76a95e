"""How often intervals hold the truth, on games whose expert's reward is drawn from the prior.

Each run is a random Markov game (Dirichlet transitions) with one weight for every state and joint action, drawn
from N(0, 1), which is also the learner's prior (`reward_scale=1`). The learner lives through the game as by default.
Then, at level 0.9, how often the truth lies within the interval of

* a weight, over those that the interactions determined, and over all;
* a probability of the expert's answer to a policy that nobody played;
* the discounted return of the policy that is handed back, by draws that did not choose it.

Beside it, ranks of the true weights among draws (simulation-based calibration, Talts et al. 2018): where draws are from
the posterior, ranks are uniform. The least p-value of chi-square tests over the weights is printed times their number
(Bonferroni), for Hamiltonian Monte Carlo, for plain Laplace draws, and for those that a result keeps.

    python benchmarks/coverage.py --temperature 0.4 --runs 400
"""

import argparse
import json
import sys
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

import jax
import jax.numpy as jnp
import numpy as np
import scipy.stats
from jaxtyping import Array

import gsiirl
from gsiirl.games import TabularGame
from gsiirl.interaction import interact
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood
from gsiirl.irl.inference import LikelihoodLevel

LEVEL = 0.9
RANKED = 99
"""Draws that a true weight is ranked among: 100 ranks, in ten bins."""
AT_ONCE = 25


class Found(NamedTuple):
    """What one run shows; a leading axis of runs in all together."""

    within: Array
    determined: Array
    answers: Array
    returned: Array
    ranks: dict[str, Array]


def problem_of(seed: int, states: int, actions: tuple[int, int], horizon: int, temperature: float) -> tuple[Any, Any]:
    """A game, and the expert whose reward is drawn from the prior."""
    random = np.random.default_rng(seed)
    shape = (states, *actions)
    game = TabularGame.from_arrays(
        random.dirichlet(np.ones(states), shape), initial=np.full(states, 1 / states), horizon=horizon
    )
    problem = gsiirl.Problem(
        game,
        own_reward=random.normal(size=shape[:2]),
        dependent_value=random.normal(size=shape),
        temperature=temperature,
        reward_scale=1.0,
    )
    return problem, gsiirl.RespondingExpert(game, random.normal(size=shape), temperature, problem.discount)


@partial(jax.jit, static_argnums=(3, 4))
def lived(learners: Any, experts: Any, keys: Array, iterations: int, trajectories: int) -> Found:
    """All runs of a batch."""
    return jax.vmap(lambda learner, expert, key: _one(learner, expert, key, iterations, trajectories))(
        learners, experts, keys
    )


def _one(learner: Any, expert: Any, key: Array, iterations: int, trajectories: int) -> Found:
    keys = jax.random.split(key, 8)
    carry = (learner.init(keys[0]), None)
    (state, _), _ = interact(learner, expert, carry, keys[1], 0, iterations, trajectories, lambda met: {})
    policy = learner.end(state, keys[2]).policies.learner
    draws = learner.posterior_draws(state, keys[3])
    level: LikelihoodLevel = learner.lower
    posterior, memory, inference = state.lower.posterior, state.lower.memory, level.inference
    true = expert.reward.dense().ravel() / expert.temperature
    prior = posterior.prior_precision**-0.5

    def within(values: Array, truth: Array) -> Array:
        low, high = jnp.quantile(values, jnp.asarray([0.5 - LEVEL / 2, 0.5 + LEVEL / 2]), axis=0)
        return (low <= truth) & (truth <= high)

    unplayed = jax.random.dirichlet(keys[4], jnp.ones(policy.shape[-1]), policy.shape[:-1])
    model: ConditionalLikelihood = inference.likelihood

    def answer(weights: Array) -> Array:
        return jax.nn.softmax(model.action_values(weights, unplayed))

    def earned(weights: Array) -> Array:
        return learner.commitment.value(policy, model.features.payoff(weights))

    noise = jax.random.normal(keys[5], (RANKED, true.shape[0]))
    lower = jnp.linalg.cholesky(posterior.precision)
    plain = posterior.mean + jax.scipy.linalg.solve_triangular(lower.T, noise.T, lower=False).T
    chains = inference.hamiltonian(posterior, memory, RANKED, 100, keys[6])
    kept = draws[jax.random.permutation(keys[7], draws.shape[0])[:RANKED]]
    return Found(
        within(draws, true),
        jnp.std(draws, axis=0) <= 0.5 * prior,
        within(jax.vmap(answer)(draws), answer(true)),
        within(jax.vmap(earned)(draws), earned(true)),
        {
            name: jnp.sum(values < true, axis=0)
            for name, values in {"hmc": chains, "laplace": plain, "kept": kept}.items()
        },
    )


def main() -> None:
    """A line of JSON for a family of games after every batch; the last one counts all runs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--temperature", type=float, default=0.4)
    parser.add_argument("--states", type=int, default=2)
    parser.add_argument("--actions", default="3x2")
    parser.add_argument("--horizon", type=int, default=3)
    parser.add_argument("--iterations", type=int, default=50)
    parser.add_argument("--trajectories", type=int, default=100)
    parser.add_argument("--runs", type=int, default=400)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    learner_actions, expert_actions = map(int, asked.actions.split("x"))
    parts = []
    for first in range(asked.first, asked.first + asked.runs, AT_ONCE):
        seeds = range(first, first + AT_ONCE)
        pairs = [
            problem_of(seed, asked.states, (learner_actions, expert_actions), asked.horizon, asked.temperature)
            for seed in seeds
        ]
        learners = [gsiirl.GSIIRL(problem).learner(asked.iterations) for problem, _ in pairs]
        stacked = [
            jax.tree.map(lambda *leaves: jnp.stack([jnp.asarray(leaf) for leaf in leaves]), *each)
            for each in (learners, [expert for _, expert in pairs])
        ]
        keys = jax.vmap(jax.random.key)(jnp.asarray(seeds))
        parts.append(jax.tree.map(np.asarray, lived(*stacked, keys, asked.iterations, asked.trajectories)))
        found = jax.tree.map(lambda *each: np.concatenate(each), *parts)
        print(json.dumps(vars(asked) | {"done": first + AT_ONCE - asked.first} | table(found)), flush=True)


def table(found: Found) -> dict[str, Any]:
    """Coverage, and the calibration's least p-values."""

    def uniform(ranks: np.ndarray) -> float:
        counts = [np.bincount(each // 10, minlength=10) for each in ranks.T]
        return min(1.0, len(counts) * min(scipy.stats.chisquare(each).pvalue for each in counts))

    return {
        "weights_determined": float(found.within[found.determined].mean()),
        "weights": float(found.within.mean()),
        "determined": float(found.determined.mean()),
        "answers": float(found.answers.mean()),
        "return": float(found.returned.mean()),
        **{f"calibration_{name}": uniform(np.asarray(ranks)) for name, ranks in found.ranks.items()},
    }


if __name__ == "__main__":
    main()
