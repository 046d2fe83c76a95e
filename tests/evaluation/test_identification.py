"""What no answer of the expert can show, in games where that is known."""

import numpy as np
import pytest
from commitment_oracle import Batch, response
from small_games import HORIZON, JOINT, TERMINAL, finite_game, tabular

from gsiirl.evaluation.identification import unseen_directions
from gsiirl.games import TabularGame
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood
from gsiirl.rewards.linear import IndicatorFeatures


def unseen(game: TabularGame, shape: tuple[int, int, int], discount: float) -> np.ndarray:
    features = IndicatorFeatures(shape=shape, names=())
    return np.asarray(unseen_directions(ConditionalLikelihood(game, features, discount)))


@pytest.mark.parametrize(("learner", "expert"), [(2, 3), (3, 2)])
def test_in_a_game_of_one_step_it_is_what_depends_on_the_learner_alone(learner: int, expert: int) -> None:
    game = TabularGame.from_arrays(np.ones((1, learner, expert, 1)), initial=[1.0], horizon=1)
    found = unseen(game, (1, learner, expert), 0.9)
    assert found.shape == (learner * expert, learner)
    tables = found.T.reshape(learner, learner, expert)
    np.testing.assert_allclose(tables, np.broadcast_to(tables[:, :, :1], tables.shape), atol=1e-6)


def test_in_a_longer_game_responses_to_any_policy_stay_and_no_direction_is_left_out() -> None:
    of = finite_game()
    found = unseen(tabular(of), JOINT, of.discount)
    random = np.random.default_rng(0)
    policies = Batch(of).tidy(random.gamma(0.5, size=(4, HORIZON, *JOINT[:2])) + 1e-6)
    alive = ~np.asarray(TERMINAL)

    def moved(direction: np.ndarray) -> float:
        changed = type(of)(**{**vars(of), "expert": of.expert + direction.reshape(JOINT)})
        return max(np.abs(response(changed, each) - response(of, each))[:, alive].max() for each in policies)

    assert found.shape[1] >= 1
    for direction in found.T:
        assert moved(direction) < 1e-5
    left = random.normal(size=found.shape[0])
    left -= found @ (found.T @ left)
    assert moved(left / np.linalg.norm(left)) > 1e-3
