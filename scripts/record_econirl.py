"""Record what econirl's nested fixed point makes of a decision process, for the tests.

Usage: python scripts/record_econirl.py [--output tests/data/econirl_nfxp.npz]

Needs econirl 0.1.1, which this project does not depend on (it needs jaxopt). Its estimate is the most likely one,
without a prior, and its process goes on for ever; its standard errors are those of the inverse Hessian. The process and
the data are drawn from numpy's default_rng(0): see `process` and `behaviour`. econirl rounds its estimate to single
precision.

Entries of the file (float64; 100 steps, 6 states, 3 actions, 4 parameters):

transitions [6, 3, 6]     chances of the next state
features [6, 3, 4]        features of the reward
counts [100, 6, 3]        how many of 300 episodes are where, and choose what, in each step
estimate [4]              parameters, from `NFXPEstimator`
errors [4]                their standard errors
log_likelihood            at the estimate
versions [3] str          econirl, Python, numpy
"""

import argparse
import platform
from importlib.metadata import version
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from econirl.core.reward_spec import RewardSpec  # pyright: ignore[reportMissingImports]
from econirl.core.types import DDCProblem, Panel, Trajectory  # pyright: ignore[reportMissingImports]
from econirl.estimation.nfxp import NFXPEstimator  # pyright: ignore[reportMissingImports]

STATES, ACTIONS, PARAMETERS = 6, 3, 4
DISCOUNT, STEPS, EPISODES = 0.3, 100, 300


def process(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Transitions (S, A, S), features (S, A, 4) of the reward, and the true parameters (4,)."""
    transitions = random.dirichlet(np.ones(STATES), (STATES, ACTIONS))
    return transitions, random.normal(size=(STATES, ACTIONS, PARAMETERS)), random.normal(size=PARAMETERS)


def behaviour(
    random: np.random.Generator, transitions: np.ndarray, reward: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States, actions and next states (episodes, steps) of an agent at temperature 1 that plans for ever."""
    values = np.zeros(STATES)
    for _ in range(200):
        action_values = reward + DISCOUNT * transitions @ values
        values = np.log(np.exp(action_values).sum(-1))
    policy = np.exp(action_values - values[:, None])
    states, actions = (np.zeros((EPISODES, STEPS), int) for _ in range(2))
    following = np.zeros((EPISODES, STEPS), int)
    for episode, step in np.ndindex(EPISODES, STEPS):
        state = following[episode, step - 1] if step else random.integers(STATES)
        action = random.choice(ACTIONS, p=policy[state])
        states[episode, step], actions[episode, step] = state, action
        following[episode, step] = random.choice(STATES, p=transitions[state, action])
    return states, actions, following


def main(output: Path) -> None:
    jax.config.update("jax_enable_x64", True)
    random = np.random.default_rng(0)
    transitions, features, true = process(random)
    data = behaviour(random, transitions, features @ true)
    panel = Panel([Trajectory(*(jnp.asarray(each) for each in episode)) for episode in zip(*data, strict=True)])
    names = [f"theta_{index}" for index in range(PARAMETERS)]
    found = NFXPEstimator(se_method="asymptotic", optimizer="BHHH", outer_tol=1e-10).estimate(
        panel,
        RewardSpec(jnp.asarray(features), names),
        DDCProblem(STATES, ACTIONS, DISCOUNT, 1.0),
        jnp.asarray(transitions.transpose(1, 0, 2)),
    )
    versions = np.array([version("econirl"), platform.python_version(), np.__version__])
    estimate, errors = (np.asarray(each, float) for each in (found.parameters, found.standard_errors))
    likelihood = np.asarray(found.log_likelihood, float)
    counts = np.zeros((STEPS, STATES, ACTIONS))
    np.add.at(counts, (np.broadcast_to(np.arange(STEPS), data[0].shape), data[0], data[1]), 1.0)
    np.savez_compressed(
        output,
        transitions=transitions,
        features=features,
        counts=counts,
        estimate=estimate,
        errors=errors,
        log_likelihood=likelihood,
        versions=versions,
    )
    print(f"{output}: {estimate} with errors {errors}; the truth {true}; {found.converged=}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--output", type=Path, default=Path("tests/data/econirl_nfxp.npz"))
    main(parser.parse_args().output)
