"""What the learner of a finite game plays while it learns."""

from dataclasses import replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from commitment_oracle import Batch, Floats, response
from problems import tiny_problem
from small_games import HORIZON, JOINT, expected_counts, expert_of, finite_game, problem_of, tabular

from gsiirl import GSIIRL
from gsiirl.commitment.search import SMALL, Search
from gsiirl.irl.dependent_reward import DependentFit
from gsiirl.irl.posterior import Draws, Inference
from gsiirl.learners.commitment_learner import CommitmentLearner, Explore, Feedback
from gsiirl.limits import remembered

GAME = finite_game()
KEY = jax.random.key(0)


def nats(policy: Floats, weights: Floats, others: Floats) -> float:
    """How far two experts' answers to a policy are apart in an episode, where the first one lives."""
    first, second = (replace(GAME, expert=each.reshape(JOINT) * GAME.temperature) for each in (weights, others))
    counts = expected_counts(first, policy)
    seen = counts > 0
    apart = np.log(response(first, policy)[seen]) - np.log(response(second, policy)[seen])
    return float((counts[seen] * apart).sum())


def test_what_is_played_to_learn_tells_the_draw_from_the_estimate_best() -> None:
    learner = jax.tree.map(jnp.asarray, GSIIRL(problem_of(GAME)).learner(4))
    random = np.random.default_rng(0)
    estimate, draw = random.normal(size=(2, GAME.expert.size))
    policies = Batch(GAME).tidy(random.gamma(0.5, size=(3, HORIZON, *JOINT[:2])) + 1e-6)
    chosen = eqx.filter_jit(lambda *given: learner.commitment.policy(learner._telling(*given)))(
        jnp.log(policies), jnp.asarray([estimate, draw]), KEY
    )
    told = nats(np.asarray(chosen), draw, estimate)
    pure = Batch(GAME).tidy(np.broadcast_to(np.eye(JOINT[1])[:, None, None], (JOINT[1], HORIZON, *JOINT[:2])) + 1e-13)
    assert told >= max(nats(policy, draw, estimate) for policy in (*policies, *pure)) - 1e-9


def test_the_first_half_of_the_iterations_is_for_learning_alone() -> None:
    assert GSIIRL(problem_of(GAME)).learner(9).informative_rounds == 4


def test_f_is_of_the_true_values_of_r_ld_or_of_what_was_read_of_them() -> None:
    count = np.arange(GAME.dependent.size).reshape(JOINT) % 3
    read = DependentFit(jnp.asarray(1.0 * count.ravel()), jnp.asarray((count * GAME.dependent).ravel()))
    own = GAME.own[..., None]
    unit = np.abs(GAME.dependent + own).max()
    seen: dict[Feedback, np.ndarray] = {"model": GAME.dependent, "visited": np.where(count > 0, GAME.dependent, 0.0)}
    for feedback, values in seen.items():
        learner = jax.tree.map(jnp.asarray, GSIIRL(problem_of(GAME), feedback=feedback).learner(4))
        table = learner.commitment_of(read).learner_reward.dense()
        np.testing.assert_allclose(table, (values + own) / unit, atol=1e-9)


def test_as_many_interactions_are_remembered_as_there_is_room_for() -> None:
    # With 3 states, 2 actions of the one side and 3 of the other a policy of 2^14 steps takes 15 * 2^14 numbers.
    for horizon, iterations, expected in ((3, 50, 50), (2**14, 50, 50), (2**14, 100, 68), (2**20, 50, 8), (3, 0, 1)):
        assert remembered(tabular(GAME, horizon=horizon).policy_size, iterations) == expected


def test_larger_games_have_fewer_draws() -> None:
    # A policy of one step takes 15 numbers.
    for horizon, draws in ((3, 48), (68, 48), (69, 24), (SMALL // 15, 24), (SMALL // 15 + 1, 12)):
        assert GSIIRL(problem_of(GAME, game=tabular(GAME, horizon=horizon))).learner(4).draws == draws


def test_intervals_rest_on_eight_draws_for_each_that_the_learner_weighs() -> None:
    learner = jax.tree.map(jnp.asarray, GSIIRL(problem_of(GAME)).learner(4))
    draws = eqx.filter_eval_shape(lambda key: learner.posterior_draws(learner.init(key), key), KEY)
    assert draws.shape == (8 * 48, GAME.expert.size)


@pytest.mark.parametrize(("effective", "sampled"), [(4.7, True), (4.9, False)])
def test_below_a_tenth_of_effective_draws_chains_take_their_place(
    effective: float, sampled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    learner = jax.tree.map(jnp.asarray, GSIIRL(problem_of(GAME)).learner(4))
    drawn, chains = jnp.zeros((48, 18)), jnp.ones((48, 18))
    weights, rounds = jnp.arange(48.0) / 1128, []
    monkeypatch.setattr(Inference, "draws", lambda *_: Draws(drawn, weights, jnp.asarray(effective)))
    monkeypatch.setattr(Inference, "hamiltonian", lambda *given: rounds.append(int(given[4])) or chains)
    # Of the state nothing else is looked at.
    state = eqx.tree_at(lambda at: at.lower, eqx.filter_eval_shape(learner.init, KEY), learner.lower.init(4))
    believed, told = learner._believed(state, KEY, KEY)
    assert (bool(told), rounds) == (sampled, [60 if sampled else 0])
    np.testing.assert_array_equal(believed.values, chains if sampled else drawn)
    np.testing.assert_allclose(believed.weights, np.full(48, 1 / 48) if sampled else weights)


@pytest.mark.parametrize(("effective", "sampled"), [(14.0, True), (15.0, False)])
def test_below_three_tenths_of_effective_draws_a_chain_is_played_for(
    effective: float, sampled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    class SeenError(Exception):
        """Ends the update where the draw is known."""

    def improved(learner: Any, objective: Any, believed: Any, *rest: Any) -> None:
        raise SeenError(np.asarray(believed[1]))

    learner = jax.tree.map(jnp.asarray, GSIIRL(problem_of(GAME)).learner(4))
    draws = Draws(jnp.zeros((48, 18)), jnp.full(48, 1 / 48), jnp.asarray(effective))
    monkeypatch.setattr(Inference, "fit", lambda inference, before, memory, key: before)
    monkeypatch.setattr(Inference, "draws", lambda *_: draws)
    monkeypatch.setattr(Inference, "hamiltonian", lambda *given: jnp.where(given[4] > 0, jnp.ones((1, 18)), 0.0))
    monkeypatch.setattr(CommitmentLearner, "_improved", improved)
    state = learner.init(KEY)
    expert = jax.tree.map(jnp.asarray, expert_of(GAME))
    seen = expert.meet(None, learner.propose(state), 5, KEY)[1]
    with pytest.raises(SeenError) as found:
        learner.update(state, seen, KEY)
    np.testing.assert_array_equal(found.value.args[0], np.full(18, 1.0 if sampled else 0.0))


@pytest.mark.parametrize("explore", ["informative", "thompson"])
def test_what_tells_most_is_played_in_the_first_half_alone(explore: Explore, monkeypatch: pytest.MonkeyPatch) -> None:
    learner = jax.tree.map(jnp.asarray, GSIIRL(problem_of(GAME), explore=explore).learner(4))
    shape = (HORIZON, *JOINT[:2])
    pools, telling = jnp.zeros((2, 4, *shape)).at[1].set(jnp.arange(2.0)), jnp.zeros(shape).at[..., 0].set(5.0)
    monkeypatch.setattr(Inference, "fit", lambda inference, before, memory, key: before)
    monkeypatch.setattr(Inference, "hamiltonian", lambda *given: jnp.zeros((1, 18)))
    monkeypatch.setattr(CommitmentLearner, "_improved", lambda *given: pools)
    monkeypatch.setattr(CommitmentLearner, "_telling", lambda *given: telling)
    expert = jax.tree.map(jnp.asarray, expert_of(GAME))
    state = learner.init(KEY)
    seen = expert.meet(None, learner.propose(state), 5, KEY)[1]
    for count in range(4):
        state = eqx.tree_at(lambda one: one.count, state, jnp.asarray(float(count)))
        after = learner.update(state, seen, KEY)
        expected = telling if explore == "informative" and count < 2 else pools[1, 0]
        np.testing.assert_allclose(learner.propose(after).policy, learner.commitment.policy(expected))
        # Under the estimate, which is 0 here, the expert answers uniformly.
        unknowing = replace(GAME, expert=np.zeros(JOINT))
        best, played = Batch(unknowing).values(
            np.stack([np.asarray(learner.commitment.policy(each)) for each in (pools[0, 0], expected)])
        )
        assert float(after.played_loss) == pytest.approx(best - played, abs=1e-9)


@pytest.mark.slow
def test_how_many_starts_the_searches_have(monkeypatch: pytest.MonkeyPatch) -> None:
    class StopError(Exception):
        """Ends a search where its starts are known."""

    found: dict[str, int] = {}

    def neighbours(search: Any, objective: Any, logits: Any, theta: Any, number: int, key: Any) -> Any:
        found["near"] = number
        return jnp.broadcast_to(logits, (number, *logits.shape))

    def ascend(search: Any, objective: Any, starts: Any, believed: Any) -> None:
        found["iteration"] = len(starts.temperature)
        raise StopError

    def best(search: Any, objective: Any, starts: Any, *rest: Any) -> None:
        found["end"] = len(starts.temperature)
        raise StopError

    learner = jax.tree.map(jnp.asarray, GSIIRL(problem_of(GAME)).learner(50))
    state = learner.init(KEY)
    monkeypatch.setattr(Search, "neighbours", neighbours)
    monkeypatch.setattr(Search, "ascend", ascend)
    monkeypatch.setattr(Search, "best", best)
    believed, played = jnp.zeros((2, 18)), jnp.zeros((HORIZON, *JOINT[:2]))
    with pytest.raises(StopError):
        learner._improved(learner._objective(state.accessed), believed, state.pool, played, KEY)
    with pytest.raises(StopError):
        learner.end(state, KEY)
    # For each of two rewards: three of the pool, what was played, two disturbed, a new one and three beside the best.
    assert found == {"near": 3, "iteration": 2 * 10, "end": 4 + 2 * 10 + 2 * 10}


@pytest.mark.parametrize(("horizon", "draws", "last"), [(3, 48, 8 + 8), (SMALL // 15 + 1, 12 // 2, 4 + 4)])
def test_large_games_draw_half_in_an_iteration_and_end_with_half_as_many_candidates(
    horizon: int, draws: int, last: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    class SeenError(Exception):
        """Ends what is traced where its size is known."""

    def drawn(inference: Any, posterior: Any, memory: Any, number: int, key: Any) -> None:
        raise SeenError(number)

    def best(search: Any, objective: Any, starts: Any, *rest: Any) -> Any:
        return starts.logits, None

    def ascend(search: Any, objective: Any, starts: Any, believed: Any) -> None:
        raise SeenError(len(starts.temperature))

    game = tabular(GAME, horizon=horizon)
    learner = jax.tree.map(jnp.asarray, GSIIRL(problem_of(GAME, game=game)).learner(50))
    expert = jax.tree.map(jnp.asarray, replace(expert_of(GAME), game=game))
    state = eqx.filter_eval_shape(learner.init, KEY)
    seen = eqx.filter_eval_shape(lambda at: expert.meet(None, learner.propose(at), 5, KEY)[1], state)
    monkeypatch.setattr(Inference, "draws", drawn)
    with pytest.raises(SeenError) as found:
        eqx.filter_eval_shape(learner.update, state, seen, KEY)
    assert found.value.args == (draws,)
    monkeypatch.undo()
    monkeypatch.setattr(Search, "best", best)
    monkeypatch.setattr(Search, "ascend", ascend)
    with pytest.raises(SeenError) as found:
        eqx.filter_eval_shape(learner.end, state, KEY)
    assert found.value.args == (last,)


def test_the_defender_of_a_network_earns_in_the_units_of_its_file() -> None:
    learner = tiny_problem().learner
    assert isinstance(learner, CommitmentLearner)
    assert learner.unit == 1.0
