"""Train an attacker with Stable-Baselines3 against the defender that a run learned, and say what it earns.

    pip install '.[pettingzoo]' stable-baselines3
    gsiirl run security --seeds 1 --iterations 10 --out my-run
    python examples/train_attacker.py my-run

PPO meets the learned defender in `gsiirl.pettingzoo.against`, a Gymnasium environment. It is judged, as are random play
and the true expert, over new episodes; ± is half of a 95 % interval over training seeds (Student's t).
"""

import sys
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import torch
from scipy.stats import t as student
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env

from gsiirl.equilibria.response import respond
from gsiirl.irl.expectations import expected_return
from gsiirl.pettingzoo import Player, against, expert_player, learned_player, run_env
from gsiirl.types import Sides

SEEDS, STEPS, EPISODES, ENVIRONMENTS = 5, 40_000, 1000, 8


def main(run: str) -> None:
    torch.set_num_threads(1)
    defender = learned_player(run, "defender")
    print(f"{SEEDS} seeds, {STEPS:,} steps of training, {EPISODES:,} episodes of each judged")

    def environment() -> Any:
        return against(run_env(run), "defender", defender)

    judged = environment()
    attacks = judged.action_space.n
    trained = []
    for seed in range(SEEDS):
        games = make_vec_env(environment, ENVIRONMENTS, seed=1000 * seed)
        # Episodes are short and their returns are not discounted.
        agent = PPO("MlpPolicy", games, gamma=1.0, n_steps=250, batch_size=250, ent_coef=0.01, seed=seed, device="cpu")
        agent.learn(STEPS)
        trained.append(
            mean_return(judged, lambda seen, _, agent=agent: agent.predict(seen, deterministic=True)[0], seed)
        )
    random = [mean_return(judged, lambda _, random: random.integers(attacks), seed) for seed in range(SEEDS)]
    expert = [mean_return(judged, expert_player(run), seed) for seed in range(SEEDS)]
    for name, values in (("random play", random), ("true expert", expert), ("PPO", trained)):
        print(f"{name:20} {interval(values)}")
    print(f"{'PPO - random play':20} {interval(np.subtract(trained, random))}")
    print(f"{'best possible':20} {best_possible(run, defender):6.2f}")


def mean_return(game: Any, player: Player, seed: int) -> float:
    """Of `player` over the episodes that `seed` decides."""
    random, total = np.random.default_rng(seed), 0.0
    game.reset(seed=10**6 + seed)
    for _ in range(EPISODES):
        seen, _ = game.reset()
        over = False
        while not over:
            seen, reward, _, over, _ = game.step(player(seen, random))
            total += reward
    return total / EPISODES


def interval(values: Any) -> str:
    """Mean, and half of its 95 % interval."""
    half = student.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / len(values) ** 0.5
    return f"{np.mean(values):6.2f} ± {half:.2f}"


def best_possible(run: str, defender: Any) -> float:
    """What the best of all attackers earns against this defender on average, computed backwards from the last step."""
    known = run_env(run).game
    with jax.enable_x64(True):
        policy = jnp.asarray(defender.table)
        best = eqx.filter_jit(respond)(known.game, policy, known.rewards.expert, 1e-6, 1.0).policy
        return float(expected_return(known.game, known.rewards.expert, Sides(policy, best), 1.0))


if __name__ == "__main__":
    main(sys.argv[1])
