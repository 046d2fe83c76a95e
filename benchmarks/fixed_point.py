"""Does the lower level of the continuous games stand still at the true reward?

The learner lives with a real expert as in a run, with θ_e held at the truth. Then, for an interaction of its own play
and for an exploring one, over episodes from new starts:

    g = μ(modelled response under the true r_e) − μ(real expert)      and the statistic gᵀ Σ⁻¹ g,

Σ being the covariance of g by sampling. Beside it stands the same between two real experts that were trained apart in
the same run: no model of one of them can be held to more.

    python benchmarks/fixed_point.py deception --at 20,21 --seeds 2
    python benchmarks/fixed_point.py crossing --at 40 --seeds 2
"""

import argparse
from dataclasses import replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from continuous_games import GAMES, experiment_of
from scipy.stats import chi2

from gsiirl.equilibria.policy_network import PolicyNetwork
from gsiirl.experiments.continuous.experiment import ContinuousExperiment
from gsiirl.experiments.continuous.run import expert_of, learner_of
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.learners.continuous_learner import Lived
from gsiirl.types import Sides

PLACES = 4000
"""Transitions over which the nearest weights to the true reward are found, where the class cannot express it."""


def nearest(experiment: ContinuousExperiment) -> jax.Array:
    """The θ_e of length 1 whose reward is nearest to the true one, up to a factor and a constant."""
    seen = jax.vmap(experiment.anywhere)(jax.random.split(jax.random.key(1), PLACES))
    features = np.asarray(jax.vmap(experiment.problem.expert_reward.features)(seen), float)  # pyright: ignore[reportAttributeAccessIssue]
    values = np.asarray(jax.vmap(experiment.true_expert_reward)(seen), float)
    weights = np.linalg.lstsq(np.c_[features, np.ones(PLACES)], values, rcond=None)[0][:-1]
    return jnp.asarray(weights / np.linalg.norm(weights), jnp.float32)


def statistic(one: np.ndarray, other: np.ndarray) -> tuple[float, float, float]:
    """‖g‖, gᵀ Σ⁻¹ g and √tr Σ of the difference of two sets of paired episodes' features (N, m)."""
    apart = one.astype(float) - other.astype(float)
    gap, spread = apart.mean(axis=0), np.cov(apart.T) / len(apart)
    ridge = 1e-9 * np.trace(spread) * np.eye(len(gap))
    return float(np.linalg.norm(gap)), float(gap @ np.linalg.solve(spread + ridge, gap)), float(np.trace(spread) ** 0.5)


def main() -> None:
    """Print a line for each interaction that is looked at."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("game", choices=GAMES)
    parser.add_argument("--at", default="20,21", help="iterations looked at; every third one explores: 2, 5, 8, …")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--episodes", type=int, default=1000)
    arguments = parser.parse_args()
    config, experiment = experiment_of(arguments.game)
    expert, truth, discount = expert_of(config, experiment), nearest(experiment), config.discount
    problem = experiment.problem
    learner = learner_of(config, problem)
    learner = replace(learner, inner_loop=replace(learner.inner_loop, steps=lambda iteration: 0))

    def begin(seed: jax.Array) -> Any:
        keys = jax.random.split(jax.random.key(seed), 4)
        state = eqx.tree_at(lambda at: (at.expert_parameters, at.iterate), learner.init(keys[0]), (truth, truth))
        return state, [expert.init(key, learner.propose(state).policy) for key in keys[1:3]], keys[3]

    def live(carry: Any, iteration: jax.Array) -> Any:
        state, (real, apart), key = carry
        keys = jax.random.split(jax.random.fold_in(key, iteration), 4)
        proposal = learner.propose(state)
        real, met = expert.meet(real, proposal, config.trajectories, keys[0])
        played = proposal.policy
        apart = expert.adapt(apart, played, keys[1])
        after = learner.update(state, met, keys[2])
        newest: Lived = jax.tree.map(lambda leaf: leaf[0], after.memory.kept)
        modelled = learner.response(newest, experiment.true_expert_reward, keys[3])
        starts = initial_states(problem.game, jax.random.key(2), arguments.episodes)

        def features(policy: PolicyNetwork) -> jax.Array:
            episodes = episodes_from(problem.game, Sides(played, policy), starts)
            each = jax.vmap(jax.vmap(problem.expert_reward.features))(episodes)  # pyright: ignore[reportAttributeAccessIssue]
            return jnp.einsum("ntm,t->nm", each, discount ** jnp.arange(each.shape[1], dtype=each.dtype))

        looked_at = {"real": real.policy, "apart": apart.policy, "modelled": modelled.policy, "clone": newest.clone}
        return (after, [real, apart], key), {name: features(policy) for name, policy in looked_at.items()}

    carry = jax.jit(jax.vmap(begin))(jnp.arange(arguments.seeds))
    step = jax.jit(jax.vmap(live, (0, None)))
    wanted = [int(each) for each in arguments.at.split(",")]
    quantile = chi2.ppf(0.95, len(truth))
    print(f"chi-square's 95 % point: {quantile:.1f}")
    for iteration in range(max(wanted) + 1):
        carry, features = step(carry, jnp.asarray(iteration))
        for seed in range(arguments.seeds) if iteration in wanted else ():
            each = {name: np.asarray(value[seed]) for name, value in features.items()}
            for name in ("apart", "modelled", "clone"):
                size, weighed, noise = statistic(each[name], each["real"])
                print(
                    f"{arguments.game} iteration {iteration} seed {seed} {name:>9}:"
                    f" |g| {size:.3f} (sampling {noise:.3f}), g' S^-1 g {weighed:.0f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
