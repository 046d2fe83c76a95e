"""What a result says of the expert's answers and of its own return, by draws of the posterior."""

from dataclasses import replace

import numpy as np
import pytest
from commitment_oracle import Batch, FiniteGame, Floats, extremes, learner_return, response
from small_games import HORIZON, JOINT, finite_game, made_result, problem_of

from gsiirl.errors import InputError
from gsiirl.front_door.learned_reward import LearnedReward
from gsiirl.front_door.transfer import carried_over

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


def test_a_policy_for_the_same_problem_is_the_best_under_both_learned_rewards():
    wanted, lost = np.random.default_rng(4).normal(size=(2, *JOINT))
    learned = replace(finite_game(temperature=3.0), expert=3 * wanted, dependent=lost)
    problem = problem_of(learned)
    rewards = LearnedReward(problem.expert_names, learned.expert.ravel(), problem.expert_features)
    losses = LearnedReward(problem.dependent_names, lost.ravel(), problem.dependent_features)
    result = replace(made_result(problem), expert_reward=rewards, dependent_reward=losses)
    ceiling, _, floor = extremes(learned)
    earned = learner_return(learned, result.policy_for(result.problem))
    assert earned == pytest.approx(ceiling, abs=1e-4 * (ceiling - floor))


def test_a_policy_for_another_problem_is_of_its_game_and_its_own_reward_and_reads_no_value():
    changed = replace(finite_game(5), own=np.array([[0.0, -50.0], [0.0, 0.0], [0.0, 0.0]]))
    policy = RESULT.policy_for(problem_of(changed))
    # In the first state the second action costs far more than all that was learned.
    assert policy[:, 0, 0].min() > 0.99
    other_values = problem_of(changed, dependent_value=100 * np.random.default_rng(0).normal(size=JOINT))
    np.testing.assert_array_equal(RESULT.policy_for(other_values), policy)


def test_what_was_learned_goes_by_the_names_of_its_weights():
    known, weights = ["a", "b", "c"], np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(carried_over("expert", ["c", "a"], known, weights), [3.0, 1.0])
    with pytest.raises(InputError, match="problem: its expert_features have a 'd', of which nothing was learned; give"):
        carried_over("expert", ["a", "d"], known, weights)


def test_only_a_finite_problem_can_be_transferred_to():
    with pytest.raises(InputError, match="problem: is str; give"):
        RESULT.policy_for("the same")
