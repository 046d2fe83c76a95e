"""Record a decision process as solved by imitation's maximum-causal-entropy planner, for the tests.

Usage: python scripts/record_imitation.py [--output tests/data/imitation_mce.npz]

Needs imitation 1.0.1, which this project does not depend on. Its planner is for rewards of the state alone, without
discount, at temperature 1. The process is drawn from numpy's default_rng(0): see `process`.

Entries of the file (float64; T = 10 steps, 256 states, 10 actions):

values [T, 256]           soft values V_t(s), from `mce_partition_fh`
policy [2, 256, 10]       the policy in the first and the second step
occupancy [256]           expected number of visits of each state in the T steps, from `mce_occupancy_measures`
seconds [2]               processor time of both together, the work of a gradient: median and least of 200, one thread
versions [3] str          imitation, Python, numpy
"""

import argparse
import platform
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np
from imitation.algorithms.mce_irl import (  # pyright: ignore[reportMissingImports]
    mce_occupancy_measures,
    mce_partition_fh,
)
from seals.base_envs import TabularModelMDP  # pyright: ignore[reportMissingImports]

STATES, ACTIONS, HORIZON = 256, 10, 10


def process() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Transitions (S, A, S), where an episode starts (S,), and the reward of a state (S,)."""
    random = np.random.default_rng(0)
    transitions = random.dirichlet(np.full(STATES, 0.05), (STATES, ACTIONS))
    return transitions, random.dirichlet(np.ones(STATES)), random.normal(size=STATES)


def main(output: Path) -> None:
    transitions, start, reward = process()
    env = TabularModelMDP(
        transition_matrix=transitions, reward_matrix=reward, horizon=HORIZON, initial_state_dist=start
    )
    values, _, policy = mce_partition_fh(env, discount=1.0)
    # It has T + 1 rows: the last is the state after the last step.
    occupancy = mce_occupancy_measures(env, pi=policy, discount=1.0)[0][:HORIZON].sum(0)
    taken = []
    for _ in range(200):
        began = time.process_time()
        _, _, found = mce_partition_fh(env, reward=reward, discount=1.0)
        mce_occupancy_measures(env, pi=found, discount=1.0)
        taken.append(time.process_time() - began)
    seconds = np.array([np.median(taken), np.min(taken)])
    versions = np.array([version("imitation"), platform.python_version(), np.__version__])
    np.savez_compressed(
        output, values=values, policy=policy[:2], occupancy=occupancy, seconds=seconds, versions=versions
    )
    print(f"{output}: {1e3 * seconds[0]:.2f} ms a gradient (median), {1e3 * seconds[1]:.2f} ms (least)")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--output", type=Path, default=Path("tests/data/imitation_mce.npz"))
    main(parser.parse_args().output)
