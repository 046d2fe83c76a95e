"""Cooperation, competition and only watching on random games, against solvers of their own (docs/special-cases.md).

python benchmarks/special_cases.py cooperative --games 30
python benchmarks/special_cases.py competitive --games 30
python benchmarks/special_cases.py classic --games 30
"""

import argparse
import math
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

import commitment_oracle as oracle
import small_games
import special_case_oracles

import gsiirl
from gsiirl.errors import FitWarning
from gsiirl.front_door.result import Result
from gsiirl.games import TabularGame

STATES, LEARNER, EXPERT, HORIZON, TEMPERATURE = 3, 2, 3, 3, 0.2


def learned(game: oracle.FiniteGame, iterations: int) -> Result:
    """What living with the expert of a game for some iterations of 100 trajectories comes to."""
    problem, expert = small_games.problem_of(game), small_games.expert_of(game)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FitWarning)
        return gsiirl.GSIIRL(problem).fit(expert, iterations, 100, seed=0, progress=False)


def two_sided(seed: int, sign: float, iterations: int) -> dict[str, float]:
    """One random game with r_ld = ±r_e and r_li = 0; numbers in percent, bounds in units of the reward."""
    game = oracle.random_markov(STATES, LEARNER, EXPERT, HORIZON, TEMPERATURE, seed)
    game = replace(game, dependent=sign * game.expert, own=0.0 * game.own)
    policy = learned(game, iterations).policy
    row = {}
    least, safe = special_case_oracles.soft_minimax(game)
    ceiling, _, floor = oracle.extremes(game, starts=32, policies=[policy, safe] if sign < 0 else [policy])
    earned = oracle.learner_return(game, policy)
    uniform = oracle.learner_return(game, np.full((HORIZON, STATES, LEARNER), 1.0 / LEARNER))
    row["way missed"] = 100 * (ceiling - earned) / (ceiling - uniform)
    row["regret"] = 100 * (ceiling - earned) / (ceiling - floor)
    if sign < 0:
        most = TEMPERATURE * math.log(EXPERT) * sum(game.discount**time for time in range(HORIZON))
        row["above -V*"] = ceiling + least
        row["below the bound"] = most - least - ceiling
        row["safe regret"] = 100 * (ceiling - oracle.learner_return(game, safe)) / (ceiling - floor)
    return row


def classic(seed: int, iterations: int) -> dict[str, float]:
    """One random decision process, from sampled demonstrations through the front door: distances to the truth."""
    random = np.random.default_rng(seed)
    transitions = random.dirichlet(np.ones(STATES), (STATES, EXPERT))
    initial, reward = random.dirichlet(np.ones(STATES)), random.uniform(-1, 1, (STATES, EXPERT))
    game = TabularGame.from_arrays(transitions[:, None], initial=initial, horizon=HORIZON)
    problem = gsiirl.Problem(game, temperature=TEMPERATURE)
    expert = gsiirl.RespondingExpert(game, reward[:, None], temperature=TEMPERATURE, discount=0.95)
    truth = special_case_oracles.CausalEntropy(transitions, initial, HORIZON, 0.95)
    real = truth.solve(reward / TEMPERATURE)[1]
    row = {}
    settings = {"likelihood": {}, "matching": {"lower_level": "matching"}}
    for name, each in settings.items():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FitWarning)
            result = gsiirl.GSIIRL(problem, **each).fit(expert, iterations, 100, seed=0, progress=False)
        row[f"{name}: policy"] = float(np.abs(result.expert_policy - real).max())
        found, true = (table - table.mean(-1, keepdims=True) for table in (result.expert_reward.table[:, 0], reward))
        row[f"{name}: reward"] = float(np.abs(found - true).max())
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=["cooperative", "competitive", "classic"])
    parser.add_argument("--games", type=int, default=30)
    parser.add_argument("--iterations", type=int, default=30)
    arguments = parser.parse_args()
    began, rows = time.perf_counter(), []
    for seed in range(arguments.games):
        if arguments.kind == "classic":
            rows.append(classic(seed, arguments.iterations))
        else:
            rows.append(two_sided(seed, 1.0 if arguments.kind == "cooperative" else -1.0, arguments.iterations))
        print(seed, {name: round(value, 4) for name, value in rows[-1].items()}, file=sys.stderr, flush=True)
    print(f"{arguments.kind}, {len(rows)} games, {time.perf_counter() - began:.0f} s")
    print("| | least | median | 90 % | greatest |\n|---|---|---|---|---|")
    for name in rows[0]:
        values = np.quantile([row[name] for row in rows], (0, 0.5, 0.9, 1))
        print(f"| {name} | " + " | ".join(f"{value:.3f}" for value in values) + " |")


if __name__ == "__main__":
    main()
