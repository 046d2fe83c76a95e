"""One small game with masks and an end for the tests of the front door: all its fits share their compiled programs."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import jax
import numpy as np
import polars
from commitment_oracle import FiniteGame, Floats, response

from gsiirl import Problem, RespondingExpert
from gsiirl.front_door.result import Result
from gsiirl.games import TabularGame

STATES, LEARNER, EXPERT, HORIZON = 3, 2, 3, 3
JOINT = (STATES, LEARNER, EXPERT)
DISCOUNT = 0.9
LEARNER_ACTIONS = np.array([[True, True], [True, False], [True, True]])
EXPERT_ACTIONS = np.array([[True, True, False], [True, True, True], [True, True, True]])
TERMINAL = np.array([False, False, True])


def finite_game(seed: int = 0, temperature: float = 0.3, scale: float = 1.0) -> FiniteGame:
    """The game of a seed as the oracle knows it; rewards and temperature times `scale`."""
    random = np.random.default_rng(seed)
    return FiniteGame(
        name=f"small {seed}",
        transitions=random.dirichlet(np.ones(STATES), size=JOINT),
        initial=np.array([0.6, 0.4, 0.0]),
        horizon=HORIZON,
        own=scale * random.uniform(-0.3, 0.3, JOINT[:2]),
        dependent=scale * random.uniform(-1, 1, JOINT),
        expert=scale * random.uniform(-1, 1, JOINT),
        discount=DISCOUNT,
        temperature=scale * temperature,
        learner_actions=LEARNER_ACTIONS,
        expert_actions=EXPERT_ACTIONS,
        terminal=TERMINAL,
    )


def tabular(of: FiniteGame, /, **changes: Any) -> TabularGame:
    """A game of the oracle as the library's."""
    arguments: dict[str, Any] = {
        "transitions": of.transitions,
        "initial": of.initial,
        "horizon": of.horizon,
        "learner_actions": of.learner_actions,
        "expert_actions": of.expert_actions,
        "terminal": of.terminal,
    } | changes
    return TabularGame.from_arrays(arguments.pop("transitions"), **arguments)


def problem_of(of: FiniteGame, /, **changes: Any) -> Problem:
    """What the learner is told of it."""
    arguments: dict[str, Any] = {
        "game": tabular(of),
        "own_reward": of.own,
        "dependent_value": of.dependent,
        "discount": of.discount,
        "temperature": of.temperature,
    } | changes
    return Problem(**arguments)


def expert_of(of: FiniteGame, /, **changes: Any) -> RespondingExpert:
    """The expert that lives in it."""
    arguments: dict[str, Any] = {
        "game": tabular(of),
        "reward": of.expert,
        "temperature": of.temperature,
        "discount": of.discount,
    } | changes
    return RespondingExpert(**arguments)


def uniform(actions: np.ndarray) -> np.ndarray:
    """The policy that chooses every allowed action equally often."""
    return np.broadcast_to(actions / actions.sum(-1, keepdims=True), (HORIZON, *actions.shape)).copy()


def expected_counts(game: FiniteGame, policy: Floats) -> Floats:
    """How often the expert that answers `policy` is expected to do what, when and where, in one episode."""
    answer, alive = response(game, policy), 1.0 - TERMINAL
    here, found = game.initial * alive, []
    for time in range(HORIZON):
        found.append(here[:, None] * answer[time])
        joint = here[:, None, None] * policy[time][:, :, None] * answer[time][:, None, :]
        here = np.einsum("sab,sabn->n", joint, game.transitions) * alive
    return np.array(found)


def made_result(given: Problem | None = None, seed: int = 0) -> Result:
    """A result that no run came to: uniform policies, weights 0, 1, 2, …, and draws of deviation 0.1 around them."""
    problem: Problem = problem_of(finite_game()) if given is None else given
    weights = np.arange(float(len(problem.expert_names))) + seed
    return Result.learned(
        problem=problem,
        seed=seed,
        trajectories=20,
        policy=uniform(LEARNER_ACTIONS),
        expert_policy=uniform(EXPERT_ACTIONS),
        expert_weights=weights,
        dependent_weights=np.arange(float(len(problem.dependent_names))),
        draws=weights + np.random.default_rng(seed).normal(0.0, 0.1, (40, len(weights))),
        history=polars.DataFrame(
            {"iteration": [1], "expert_trajectories": [20], "fit_decrement": [0.0005], "prior_deviation": [3.0]}
        ),
        played=uniform(LEARNER_ACTIONS)[None],
        answers=10.0 * uniform(EXPERT_ACTIONS)[None],
        effective_draws=40.0,
        sampled=False,
    )


@contextmanager
def counted_compilations() -> Iterator[list[str]]:
    """The programs that are compiled inside, by name; JAX's own copy of an array to the device is none."""
    names: list[str] = []

    def listen(event: str, duration: float, /, **about: Any) -> None:
        if event == "/jax/core/compile/backend_compile_duration" and about.get("fun_name") != "jit(stage)":
            names.append(str(about.get("fun_name")))

    jax.monitoring.register_event_duration_secs_listener(listen)  # pyright: ignore[reportArgumentType]
    try:
        yield names
    finally:
        jax.monitoring.unregister_event_duration_listener(listen)  # pyright: ignore[reportArgumentType]
