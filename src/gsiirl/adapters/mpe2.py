"""Physical deception as mpe2 publishes it: `simple_adversary`, which `gsiirl.games.deception` is a port of."""

import importlib.metadata
from typing import TYPE_CHECKING, Any

import numpy as np

from gsiirl.adapters.numpy_policy import NumpyPolicy
from gsiirl.errors import InputError
from gsiirl.program.command import installing

if TYPE_CHECKING:
    from pettingzoo import ParallelEnv

GOOD_AGENTS = ("agent_0", "agent_1")
"""Together the learner, which sees and moves both in this order."""
ADVERSARY = "adversary_0"
"""The expert."""
OBSERVATION_SIZES, ACTION_SIZES = (20, 8), (4, 2)
"""Of learner and expert."""


def simple_adversary(horizon: int) -> "ParallelEnv[str, Any, Any]":
    """mpe2's environment, with episodes of `horizon` steps.

    Raises:
        InputError: mpe2 is not installed.
    """
    try:
        from mpe2 import simple_adversary_v3
    except ModuleNotFoundError as error:
        raise InputError("--in", "mpe2 is not installed", f"run {installing('mpe2>=1.1.1')}") from error
    return simple_adversary_v3.parallel_env(N=2, max_cycles=horizon, continuous_actions=True)


def version() -> str:
    """Of mpe2."""
    return importlib.metadata.version("mpe2")


def play(
    environment: "ParallelEnv[str, Any, Any]", horizon: int, learner: NumpyPolicy, expert: NumpyPolicy, seed: int
) -> tuple[float, float]:
    """Undiscounted returns of learner and expert over the episode whose initial state mpe2 draws from `seed`.

    Both good agents are paid the same reward: the learner's.
    """
    observations, _ = environment.reset(seed=seed)
    learner_return = expert_return = 0.0
    for step in range(horizon):
        time = step / horizon
        action = learner(np.concatenate([observations[name] for name in GOOD_AGENTS]), time)
        actions = {
            GOOD_AGENTS[0]: pushes(action[:2]),
            GOOD_AGENTS[1]: pushes(action[2:]),
            ADVERSARY: pushes(expert(observations[ADVERSARY], time)),
        }
        observations, rewards, *_ = environment.step(actions)
        learner_return += rewards[GOOD_AGENTS[0]]
        expert_return += rewards[ADVERSARY]
    return learner_return, expert_return


def pushes(action: np.ndarray) -> np.ndarray:
    """mpe2's action (none, left, right, down, up) in [0, 1] for ours, (x, y) in [−1, 1]."""
    x, y = action
    return np.array([0.0, max(-x, 0.0), max(x, 0.0), max(-y, 0.0), max(y, 0.0)], np.float32)
