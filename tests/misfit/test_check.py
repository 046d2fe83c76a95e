"""The check names what an expert does instead of responding softly, and accuses nobody else."""

from collections.abc import Callable
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from commitment_oracle import response
from small_games import EXPERT_ACTIONS, HORIZON, JOINT, LEARNER, STATES, finite_game, made_result, problem_of

from gsiirl.errors import InputError
from gsiirl.front_door.result import Result
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood
from gsiirl.misfit.check import SOMETHING_ELSE, ModelCheck, _discrepancies, _fitted
from gsiirl.misfit.models import OTHERS, STANDARD, Observed

MISSING = finite_game(1, temperature=0.4)
"""Its expert's reward is that of no feature."""
FEATURES = {f"feature {place}": np.random.default_rng(place).normal(size=JOINT) for place in range(3)}
WEIGHTS = np.array([0.8, -0.5, 0.6])
GAME = replace(MISSING, expert=sum(weight * each for weight, each in zip(WEIGHTS, FEATURES.values(), strict=True)))
PROBLEM = problem_of(GAME, expert_features=FEATURES)
ROUNDS, VISITS = 8, 300

Answer = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""π_e from the policy that is played and the one before it."""


def softly(policy: np.ndarray, before: np.ndarray) -> np.ndarray:
    return response(GAME, policy)


def with_lapses(policy: np.ndarray, before: np.ndarray) -> np.ndarray:
    return 0.8 * response(GAME, policy) + 0.2 * EXPERT_ACTIONS / EXPERT_ACTIONS.sum(axis=1, keepdims=True)


def late(policy: np.ndarray, before: np.ndarray) -> np.ndarray:
    return response(GAME, before)


def best_and_second(policy: np.ndarray, before: np.ndarray) -> np.ndarray:
    order = np.argsort(-response(GAME, policy), axis=-1)
    chances = np.zeros(order.shape)
    np.put_along_axis(chances, order, np.array([0.6, 0.4, 0.0]), axis=-1)
    return chances


def result_of(answer: Answer) -> Result:
    """A result that saw `VISITS` choices in every state at every time; its estimate is the truth, without doubt."""
    source = np.random.default_rng(0)
    played = source.dirichlet(np.ones(LEARNER), (ROUNDS, HORIZON, STATES))
    played[:, :, 1] = [1.0, 0.0]
    before = np.concatenate([played[:1], played[:-1]])
    answers = [source.multinomial(VISITS, answer(*each)) for each in zip(played, before, strict=True)]
    seen = np.array(answers, float)
    seen[:, :, 2] = 0.0
    made = made_result(PROBLEM)
    made.expert_reward.weights[:], made.expert_reward.draws = WEIGHTS, np.broadcast_to(WEIGHTS, (40, 3))
    return replace(made, played=played, answers=seen)


def check(answer: Answer) -> ModelCheck:
    return result_of(answer).check()


def test_nothing_speaks_against_an_expert_that_responds_softly() -> None:
    told = check(softly)
    assert told.named is None
    assert told.p_value > 0.01
    assert max(told.gains["gain"].to_list()) < 5.0
    assert str(told).startswith("Nothing speaks against a soft best response")


def test_lapses_are_named_with_their_chance() -> None:
    told = check(with_lapses)
    assert told.named == "lapses"
    assert told.p_value < 0.01
    assert told.chances == (pytest.approx(0.2, abs=0.03),)
    assert "it picks any action with chance 0.2" in str(told)
    assert told.gains.filter(told.gains["named"])["model"].to_list() == ["lapses"]


def test_who_answers_the_policy_before_is_late() -> None:
    told = check(late)
    assert told.named == "late"
    assert max(told.gains["gain"].to_list()) > 20.0


def test_who_takes_the_second_best_now_and_then_is_named_with_both_chances() -> None:
    told = check(best_and_second)
    assert told.named == "ranks"
    assert told.chances == (pytest.approx(0.6, abs=0.03), pytest.approx(0.4, abs=0.03))


def test_ranks_end_with_a_sharp_order_which_fits_better_than_a_blurred_one() -> None:
    result = result_of(best_and_second)
    expert = ConditionalLikelihood(PROBLEM.game, PROBLEM.expert_features, PROBLEM.discount)
    seen = Observed(*map(jnp.asarray, (result.played, result.played, result.answers)))
    [ranks] = [model for model in OTHERS if model.name == "ranks"]
    with jax.enable_x64(True), jax.numpy_dtype_promotion("standard"):
        blurred, sharp = (
            _fitted(model, jax.tree.map(jnp.asarray, expert), WEIGHTS, 0.1, seen)
            for model in (ranks._replace(sharper=(10.0,)), ranks)
        )
    assert np.linalg.norm(sharp.parameters[:3]) == pytest.approx(300.0 * np.linalg.norm(WEIGHTS))
    assert sharp.log_posterior > blurred.log_posterior + 5.0
    # Order alone tells little of how large a weight is, but not of its sign.
    assert np.corrcoef(sharp.parameters[:3], WEIGHTS)[0, 1] > 0.99


def test_who_cares_for_what_no_feature_tells_is_something_else() -> None:
    told = check(lambda policy, before: response(MISSING, policy))
    assert told.named == SOMETHING_ELSE
    assert "perhaps a feature is missing" in str(told)


def test_both_measures_of_misfit_are_the_sums_that_they_say() -> None:
    result = result_of(with_lapses)
    expert = ConditionalLikelihood(PROBLEM.game, PROBLEM.expert_features, PROBLEM.discount)
    seen = Observed(*map(jnp.asarray, (result.played, result.played, result.answers)))
    draws = jnp.asarray(WEIGHTS / GAME.temperature)[None]
    real, simulated = _discrepancies(STANDARD, jax.tree.map(jnp.asarray, expert), draws, seen, jax.random.key(0))
    policies = np.array([response(GAME, policy) for policy in result.played])
    expected = result.answers.sum(axis=-1, keepdims=True) * policies
    cells = result.answers > 0
    deviance = 2.0 * np.sum(result.answers[cells] * np.log(result.answers[cells] / expected[cells]))
    spread = (expected * (1.0 - policies)).sum(axis=0)
    square = (result.answers - expected).sum(axis=0) ** 2
    np.testing.assert_allclose(real[0], [deviance, np.sum(square[spread > 1] / spread[spread > 1])], rtol=1e-9)
    # Lapses misfit by both, far beyond what the model makes itself.
    assert (np.asarray(simulated[0]) < 0.5 * np.asarray(real[0])).all()


def test_a_result_without_answers_cannot_be_checked() -> None:
    made = made_result(PROBLEM)
    with pytest.raises(InputError, match="check: needs the expert's answers"):
        replace(made, answers=made.answers[:0]).check()


def test_the_same_seed_tells_the_same() -> None:
    result = result_of(softly)
    assert result.check(3).p_value == result.check(3).p_value
