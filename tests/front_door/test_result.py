"""What a result says of the expert's answers and of its own return, by draws of the posterior."""

from dataclasses import replace

import numpy as np
import pytest
from commitment_oracle import Batch, FiniteGame, Floats, response
from small_games import HORIZON, JOINT, finite_game, made_result

from gsiirl.errors import InputError

GAME = finite_game()
RESULT = made_result()


def policies(number: int) -> Floats:
    return Batch(GAME).tidy(np.random.default_rng(3).gamma(0.5, size=(number, HORIZON, *JOINT[:2])) + 1e-6)


def believed() -> list[FiniteGame]:
    """The game with each draw for the expert's reward."""
    return [replace(GAME, expert=draw.reshape(JOINT)) for draw in RESULT.expert_reward.draws]


def test_an_interval_of_answers_is_of_the_responses_under_the_draws():
    [policy] = policies(1)
    answers = np.array([response(game, policy) for game in believed()])
    low, high = RESULT.answer_interval(policy, 0.5)
    alive = ~np.asarray(GAME.terminal)
    np.testing.assert_allclose(low[:, alive], np.quantile(answers, 0.25, axis=0)[:, alive], atol=1e-12)
    np.testing.assert_allclose(high[:, alive], np.quantile(answers, 0.75, axis=0)[:, alive], atol=1e-12)
    assert (high - low).max() > 0.01


def test_an_interval_of_returns_is_of_what_a_policy_earns_under_the_draws():
    [policy] = policies(1)
    for asked, played in ((None, RESULT.policy), (policy, policy)):
        values = [Batch(game).values(played[None])[0] for game in believed()]
        np.testing.assert_allclose(RESULT.return_interval(0.5, asked), np.quantile(values, [0.25, 0.75]), atol=1e-12)


def test_a_policy_may_be_the_same_at_every_step():
    policy = policies(1)[0][0]
    every = np.broadcast_to(policy, (HORIZON, *policy.shape))
    assert RESULT.return_interval(0.9, policy) == RESULT.return_interval(0.9, every)


@pytest.mark.parametrize(
    ("policy", "problem"),
    [
        (np.ones((2, 2)), "has shape"),
        (np.full(JOINT[:2], 0.4), "is no policy"),
        (np.array([[1.5, -0.5], [1.0, 0.0], [0.5, 0.5]]), "is no policy"),
        # In the second state the second action is forbidden.
        (np.array([[0.5, 0.5], [0.5, 0.5], [0.5, 0.5]]), "is no policy"),
    ],
)
def test_what_is_no_policy_of_the_learner_is_refused(policy: Floats, problem: str):
    with pytest.raises(InputError, match=f"policy: {problem}"):
        RESULT.answer_interval(policy)
