"""Updates a second of MADDPG on physical deception, collection of what it learns from included.

    .venv/bin/python benchmarks/maddpg_speed.py [--frames 250000]

An update is one critic step and one actor step of one side on 1024 transitions; 100 environments step together, and
both sides are updated once for every 100 frames. `taskset -c 0` before the command makes it one thread.
"""

import argparse
import os
import time

import equinox as eqx
import jax
import jax.numpy as jnp

from gsiirl.baselines.maddpg import Maddpg
from gsiirl.games import Deception, play
from gsiirl.rewards import deception
from gsiirl.types import Sides

EVALUATION_EPISODES = 1000


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--frames", type=int, default=250_000)
    frames = parser.parse_args().frames

    game = Deception()
    maddpg = Maddpg(game)
    rewards = Sides(
        lambda transition: deception.own_reward(transition) + deception.dependent_reward(transition),
        deception.adversary_reward,
    )
    episodes = frames // (maddpg.environments * game.horizon)
    began = time.perf_counter()
    state = maddpg.train(rewards, jax.random.key(0), 0)
    key = jax.random.key(1)
    go_on = (
        jax.jit(lambda state, key: maddpg.go_on(state, rewards, key, episodes), donate_argnums=0)
        .lower(state, key)
        .compile()
    )
    ready = time.perf_counter()
    state = jax.block_until_ready(go_on(state, key))
    seconds = time.perf_counter() - ready

    starts = jax.vmap(game.reset)(jax.random.split(jax.random.key(2), EVALUATION_EPISODES))
    seen = eqx.filter_jit(jax.vmap(lambda start: play(game, state.policies, start)))(starts)
    learner, expert = (
        float(jnp.mean(jnp.sum(jax.vmap(jax.vmap(reward))(seen), axis=1)))
        for reward in (rewards.learner, rewards.expert)
    )
    frames, updates = episodes * maddpg.environments * game.horizon, int(state.updates)
    threads = len(os.sched_getaffinity(0))
    print(
        f"setup {ready - began:.1f} s, run {seconds:.1f} s for {frames} frames on {threads} threads: "
        f"{frames / seconds:.0f} frames/s overall, {updates} updates per side x 2 sides, "
        f"{2 * updates / seconds:.1f} side updates/s (collection included); "
        f"return of the learner {learner:.2f}, of the expert {expert:.2f}"
    )


if __name__ == "__main__":
    main()
