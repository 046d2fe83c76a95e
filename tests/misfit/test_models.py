"""Other models of an expert, against sums written out in NumPy."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from small_games import (
    DISCOUNT,
    EXPERT,
    EXPERT_ACTIONS,
    HORIZON,
    LEARNER,
    STATES,
    TERMINAL,
    finite_game,
    problem_of,
)

from gsiirl.irl.conditional_likelihood import ConditionalLikelihood
from gsiirl.misfit.models import OTHERS, STANDARD, Observed

GAME = finite_game(3)
SOURCE = np.random.default_rng(5)
WEIGHTS = SOURCE.normal(size=STATES * LEARNER * EXPERT)
"""r_e/τ of every (s, a_l, a_e)."""
MODELS = {model.name: model for model in (STANDARD, *OTHERS)}
LIVING = [0, 1]


def policy_of(seed: int) -> np.ndarray:
    policy = np.random.default_rng(seed).dirichlet(np.ones(LEARNER), (HORIZON, STATES))
    policy[:, 1] = [1.0, 0.0]
    return policy


def action_values(policy: np.ndarray, ahead: int, hard: bool) -> np.ndarray:
    """Q/τ (T, S, A_e), looking `ahead` steps; −inf for what is forbidden."""
    reward = WEIGHTS.reshape(STATES, LEARNER, EXPERT)

    def value(time: int, state: int, left: int) -> float:
        if TERMINAL[state] or time == HORIZON or left == 0:
            return 0.0
        each = [q(time, state, action, left) for action in range(EXPERT) if EXPERT_ACTIONS[state, action]]
        return max(each) if hard else float(np.log(np.sum(np.exp(each))))

    def q(time: int, state: int, action: int, left: int) -> float:
        total = 0.0
        for mine in range(LEARNER):
            chances = GAME.transitions[state, mine, action]
            onward = sum(chances[after] * value(time + 1, after, left - 1) for after in range(STATES))
            total += policy[time, state, mine] * (reward[state, mine, action] + DISCOUNT * onward)
        return total

    found = np.full((HORIZON, STATES, EXPERT), -np.inf)
    for time in range(HORIZON):
        for state in LIVING:
            for action in np.flatnonzero(EXPERT_ACTIONS[state]).tolist():
                found[time, state, action] = q(time, state, action, ahead)
    return found


def softmax(scores: np.ndarray) -> np.ndarray:
    raised = np.exp(scores - scores.max(axis=-1, keepdims=True))
    return raised / raised.sum(axis=-1, keepdims=True)


def policy_by(name: str, further: tuple[float, ...] = (), size: float = 1.0) -> np.ndarray:
    problem = problem_of(GAME)
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        expert = ConditionalLikelihood(problem.game, problem.expert_features, problem.discount)
        seen = Observed(jnp.asarray(policy_of(0)), jnp.asarray(policy_of(1)), jnp.zeros((HORIZON, STATES, EXPERT)))
        weights = jnp.asarray(size * WEIGHTS)
        return np.exp(np.asarray(MODELS[name].log_policy(expert, weights, jnp.asarray(further), seen)))


@pytest.mark.parametrize(
    ("name", "played", "ahead", "hard"),
    [
        ("soft best response", 0, HORIZON, False),
        ("late", 1, HORIZON, False),
        ("short-sighted, 1 step", 0, 1, False),
        ("short-sighted, 2 steps", 0, 2, False),
        ("Boltzmann in Q*", 0, HORIZON, True),
    ],
)
def test_each_model_is_the_sum_that_it_says(name: str, played: int, ahead: int, hard: bool) -> None:
    wanted = softmax(action_values(policy_of(played), ahead, hard)[:, LIVING])
    np.testing.assert_allclose(policy_by(name)[:, LIVING], wanted, atol=1e-12)


def test_lapses_are_over_allowed_actions_alone() -> None:
    plain = softmax(action_values(policy_of(0), HORIZON, hard=False)[:, LIVING])
    anything = (EXPERT_ACTIONS / EXPERT_ACTIONS.sum(axis=1, keepdims=True))[LIVING]
    # sigmoid(ln ¼) = 1/5.
    np.testing.assert_allclose(
        policy_by("lapses", (np.log(0.25),))[:, LIVING], 0.8 * plain + 0.2 * anything, atol=1e-12
    )


def test_ranks_give_the_best_and_the_second_best_action_the_same_chances_everywhere() -> None:
    order = np.argsort(-action_values(policy_of(0), HORIZON, hard=True)[:, LIVING], axis=-1)
    found = policy_by("ranks", (np.log(0.5), np.log(0.25)), size=1e4)[:, LIVING]
    # State 0 has two actions, the other three.
    for place, chances in ((0, [2 / 3, 1 / 3, 0.0]), (1, [4 / 7, 2 / 7, 1 / 7])):
        sorted_ones = np.take_along_axis(found[:, place], order[:, place], axis=-1)
        np.testing.assert_allclose(sorted_ones, np.broadcast_to(chances, (HORIZON, EXPERT)), atol=1e-12)


def test_ranks_draw_the_best_action_softly_and_the_second_from_what_is_left() -> None:
    found = policy_by("ranks", (np.log(0.5), np.log(0.25)))[1, 1]
    first = softmax(action_values(policy_of(0), HORIZON, hard=False)[1, 1])
    wanted = np.zeros(EXPERT)
    for order in itertools.permutations(range(EXPERT)):
        chance = first[order[0]] * first[order[1]] / (1.0 - first[order[0]])
        wanted[list(order)] += chance * np.array([4 / 7, 2 / 7, 1 / 7])
    np.testing.assert_allclose(found, wanted, atol=1e-12)
