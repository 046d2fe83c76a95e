"""The front door: what `GSIIRL.fit` gives back, what it depends on, and what it does not."""

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import polars
import pytest
from commitment_oracle import extremes, learner_return, response, textbook
from small_games import (
    EXPERT,
    EXPERT_ACTIONS,
    HORIZON,
    JOINT,
    LEARNER,
    LEARNER_ACTIONS,
    STATES,
    counted_compilations,
    expert_of,
    finite_game,
    made_result,
    problem_of,
    tabular,
)

from gsiirl import GSIIRL, FitWarning, InputError, Problem, RespondingExpert, load
from gsiirl import interaction as interaction_module
from gsiirl.front_door import fit as fit_module
from gsiirl.front_door.result import Result, Results
from gsiirl.types import Sides, Trajectories

ITERATIONS, TRAJECTORIES = 3, 20
GAME = finite_game()
WEIGHTS = STATES * LEARNER * EXPERT


def fit(problem: Problem | None = None, expert: Any = None, seed: int = 0, **settings: Any) -> Any:
    """Every fit of one and the same shape, so that all share their compiled programs."""
    learner = GSIIRL(problem or problem_of(GAME))
    return learner.fit(expert or expert_of(GAME), ITERATIONS, TRAJECTORIES, seed, progress=False, **settings)


@pytest.fixture(scope="module")
def learned() -> Result:
    return fit()


class Recorder:
    """Somebody's own expert: it answers as the library's would, and keeps what it showed."""

    def __init__(self, expert: RespondingExpert) -> None:
        self.answer = jax.jit(lambda policy, number, key: expert.demonstrate(policy, number, key), static_argnums=1)
        self.shown: list[Trajectories] = []

    def demonstrate(self, policy: Any, number: int, key: Any) -> Trajectories:
        self.shown.append(self.answer(policy, number, key))
        return self.shown[-1]

    def save(self, path: Path) -> None:
        arrays = [jax.tree.map(np.asarray, each) for each in self.shown]
        np.savez(
            path,
            states=np.stack([each.states for each in arrays]),
            learner=np.stack([each.actions.learner for each in arrays]),
            expert=np.stack([each.actions.expert for each in arrays]),
            mask=np.stack([each.mask for each in arrays]),
        )


class Replayed:
    """What was recorded, shown again whatever is played; it has no reward and nothing else."""

    def __init__(self, path: Path) -> None:
        arrays = dict(np.load(path))
        self.rounds = iter(zip(*(arrays[name] for name in ("states", "learner", "expert", "mask")), strict=True))

    def demonstrate(self, policy: Any, number: int, key: Any) -> Trajectories:
        states, learner, expert, mask = (jnp.asarray(each) for each in next(self.rounds))
        return Trajectories(states, Sides(learner, expert), mask)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    """A file of demonstrations, and what was learned while they were recorded."""
    path = tmp_path_factory.mktemp("recorded") / "shown.npz"
    recorder = Recorder(expert_of(GAME))
    result = fit(expert=recorder)
    recorder.save(path)
    return path, result


def same(one: Result, other: Result) -> None:
    """See that two results are the same to the last bit."""
    for name in ("policy", "expert_policy", "played", "answers"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(one.expert_reward.weights, other.expert_reward.weights)
    np.testing.assert_array_equal(one.dependent_reward.weights, other.dependent_reward.weights)
    assert one.history.equals(other.history)
    assert (one.effective_draws, one.sampled) == (other.effective_draws, other.sampled)


# --- What comes back ---


@pytest.mark.slow
def test_a_result_holds_policies_that_are_distributions_over_what_is_allowed(learned: Result) -> None:
    for policy, actions in ((learned.policy, LEARNER_ACTIONS), (learned.expert_policy, EXPERT_ACTIONS)):
        assert isinstance(policy, np.ndarray)
        assert policy.dtype == np.float64
        assert policy.shape == (HORIZON, *actions.shape)
        np.testing.assert_allclose(policy.sum(-1), 1.0, atol=1e-12)
        assert (policy[:, ~actions] == 0).all()
    assert learned.played.shape == (ITERATIONS, HORIZON, STATES, LEARNER)
    assert (learned.played[:, :, ~LEARNER_ACTIONS] == 0).all()
    assert learned.answers.shape == (ITERATIONS, HORIZON, STATES, EXPERT)
    assert (learned.answers[:, 0].sum(axis=(1, 2)) == TRAJECTORIES).all()
    # Before anything was seen every allowed action is tried equally often.
    np.testing.assert_allclose(learned.played[0], made_result().policy, atol=1e-12)


@pytest.mark.slow
def test_the_expected_answer_is_the_response_under_the_learned_reward(learned: Result) -> None:
    believed = replace(GAME, expert=learned.expert_reward.table)
    alive = ~np.asarray(GAME.terminal)
    expected = response(believed, learned.policy)[:, alive]
    np.testing.assert_allclose(learned.expert_policy[:, alive], expected, atol=1e-12)


@pytest.mark.slow
def test_rewards_are_mappings_of_names_with_a_table(learned: Result) -> None:
    reward = learned.expert_reward
    assert len(reward) == WEIGHTS
    assert reward.table.shape == JOINT
    assert reward["state 1, learner 0, expert 2"] == reward.table[1, 0, 2]
    assert list(reward.values()) == reward.weights.tolist()
    with pytest.raises(KeyError):
        reward["state 9, learner 0, expert 0"]
    # The learner's own part is read exactly, where it has been, and is 0 elsewhere.
    table = learned.dependent_reward.table
    read = table != 0
    np.testing.assert_allclose(table[read], GAME.dependent[read], atol=1e-12)
    assert read[0, :, :2].all()
    assert not read[2].any()


@pytest.mark.slow
def test_the_history_has_a_row_an_iteration(learned: Result) -> None:
    history = learned.history
    assert isinstance(history, polars.DataFrame)
    assert history["iteration"].to_list() == [1, 2, 3]
    assert history["expert_trajectories"].to_list() == [20, 40, 60]
    assert (history["fit_converged"] == 1.0).all()
    assert (history["fit_decrement"] <= 1e-3).all()
    assert {"fit_steps", "prior_deviation", "effective_draws", "played_loss"} <= set(history.columns)


# --- What it depends on, and what it does not ---


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(learned: Result) -> None:
    told: list[tuple[int, dict[str, np.ndarray]]] = []
    same(fit(callback=lambda iteration, metrics: told.append((iteration, metrics))), learned)
    # Whoever is called back is told what the history says.
    assert [iteration for iteration, _ in told] == learned.history["iteration"].to_list()
    for name in told[0][1]:
        assert [float(metrics[name][0]) for _, metrics in told] == learned.history[name].to_list()
    assert not np.array_equal(fit(seed=1).expert_reward.weights, learned.expert_reward.weights)


@pytest.mark.slow
def test_single_precision_as_jax_has_it_by_default_changes_nothing(learned: Result) -> None:
    with jax.enable_x64(False):
        result = fit(problem_of(GAME), expert_of(GAME))
    same(result, learned)


@pytest.mark.slow
def test_another_game_another_temperature_and_another_seed_compile_nothing(learned: Result, tmp_path: Path) -> None:
    assert learned.seed == 0
    sizes = {name: function._cache_size() for name, function in compiled_functions().items()}
    with counted_compilations() as compiled:
        for seed, temperature in ((5, 0.3), (6, 0.1), (7, 0.05)):
            game = finite_game(seed, temperature)
            fit(problem_of(game), expert_of(game), seed=seed)
        fit(problem_of(GAME, temperature=None, discount=0.8))
    assert not compiled
    assert sizes == {name: function._cache_size() for name, function in compiled_functions().items()}


def compiled_functions() -> dict[str, Any]:
    once = {name: getattr(fit_module, name) for name in ("_report", "_end")}
    rounds = ("_start", "_greet", "_round_keys", "_meet", "_update")
    return once | {name: getattr(interaction_module, name)._cached for name in rounds}


@pytest.mark.slow
def test_somebodys_own_expert_teaches_what_the_compiled_one_does(
    learned: Result, recording: tuple[Path, Result]
) -> None:
    _, result = recording
    np.testing.assert_allclose(result.policy, learned.policy, atol=1e-9)
    np.testing.assert_allclose(result.expert_reward.weights, learned.expert_reward.weights, atol=1e-9)


@pytest.mark.slow
def test_recorded_demonstrations_give_the_same_bytes_again(recording: tuple[Path, Result]) -> None:
    path, result = recording
    same(fit(expert=Replayed(path)), result)


@pytest.mark.slow
def test_nothing_of_an_expert_is_looked_at_but_what_it_shows(recording: tuple[Path, Result]) -> None:
    path, result = recording

    class Closed(Replayed):
        """Has a true reward, and is unhappy when anybody asks for it."""

        def __getattribute__(self, name: str) -> Any:
            assert name in ("demonstrate", "rounds", "__class__"), f"somebody asked for {name}"
            return super().__getattribute__(name)

    for reward in (GAME.expert, -3.0 * GAME.expert):
        closed = Closed(path)
        object.__setattr__(closed, "reward", reward)
        same(fit(expert=closed), result)


@pytest.mark.slow
def test_what_is_shown_after_an_episodes_end_does_not_count(recording: tuple[Path, Result], tmp_path: Path) -> None:
    path, result = recording
    arrays = dict(np.load(path))
    over = arrays["states"] == STATES - 1
    assert over.any()
    np.testing.assert_array_equal(arrays["mask"], ~over)
    random = np.random.default_rng(0)
    # Any choice in a terminal state, masked or not; and anything at all where the mask says that it is over.
    for each in ("learner", "expert"):
        arrays[each] = np.where(over, random.integers(0, 2, over.shape), arrays[each])
    np.savez(tmp_path / "unmasked.npz", **(arrays | {"mask": np.ones_like(over)}))
    same(fit(expert=Replayed(tmp_path / "unmasked.npz")), result)
    arrays["states"] = np.where(over, -7, arrays["states"])
    np.savez(tmp_path / "masked.npz", **arrays)
    same(fit(expert=Replayed(tmp_path / "masked.npz")), result)


@pytest.mark.slow
def test_episodes_of_another_policy_are_learned_from_with_one_warning() -> None:
    class Elsewhere(Recorder):
        """Meets a learner that takes the first action it may."""

        def demonstrate(self, policy: Any, number: int, key: Any) -> Trajectories:
            first = jax.nn.one_hot(LEARNER_ACTIONS.argmax(axis=1), LEARNER)
            return super().demonstrate(jnp.broadcast_to(first, policy.shape), number, key)

    with pytest.warns(FitWarning) as said:
        fit(expert=Elsewhere(expert_of(GAME)))
    (doubt,) = (each for each in said if "demonstrations" in str(each.message))
    assert str(doubt.message).startswith("demonstrations.actions.learner are not drawn from the policy")
    assert doubt.filename == __file__


@pytest.mark.slow
def test_a_forbidden_action_that_is_demonstrated_is_refused(recording: tuple[Path, Result], tmp_path: Path) -> None:
    arrays = dict(np.load(recording[0]))
    arrays["expert"] = np.where(arrays["states"] == 0, EXPERT - 1, arrays["expert"])
    np.savez(tmp_path / "forbidden.npz", **arrays)
    with pytest.raises(InputError, match=r"^demonstrations\.actions\.expert: is 2 in state 0, which is forbidden"):
        fit(expert=Replayed(tmp_path / "forbidden.npz"))


@pytest.mark.slow
def test_units_of_reward_do_not_matter(learned: Result) -> None:
    game = finite_game(scale=20.0)
    result = fit(problem_of(game), expert_of(game))
    np.testing.assert_allclose(result.policy, learned.policy, atol=1e-6)
    np.testing.assert_allclose(result.expert_policy, learned.expert_policy, atol=1e-6)
    np.testing.assert_allclose(result.expert_reward.weights, 20 * learned.expert_reward.weights, rtol=1e-6, atol=1e-6)
    lost, before = result.history["played_loss"].to_numpy(), learned.history["played_loss"].to_numpy()
    assert np.isfinite(lost).all()
    assert lost.any()
    np.testing.assert_allclose(lost, 20 * before, rtol=1e-5, atol=1e-9)


@pytest.mark.slow
def test_a_temperature_that_is_unknown_leaves_rewards_in_units_of_it(learned: Result) -> None:
    result = fit(problem_of(GAME, temperature=None))
    np.testing.assert_array_equal(result.policy, learned.policy)
    np.testing.assert_allclose(
        result.expert_reward.weights, learned.expert_reward.weights / GAME.temperature, rtol=1e-12
    )


@pytest.mark.slow
def test_several_seeds_at_once_are_one_after_the_other() -> None:
    together = fit(seeds=2, seed=3)
    assert isinstance(together, Results)
    assert [each.seed for each in together] == [3, 4]
    for each in together:
        alone = fit(seed=each.seed)
        # In a batch sums are taken in another order; a search amplifies what rounding leaves.
        np.testing.assert_allclose(each.expert_reward.weights, alone.expert_reward.weights, atol=1e-6)
        np.testing.assert_allclose(each.policy, alone.policy, atol=1e-4)
        values = [learner_return(GAME, one.policy) for one in (each, alone)]
        assert values[0] == pytest.approx(values[1], abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings",
    [
        {"lower_level": "matching", "feedback": "visited"},
        {"many_starts": False, "explore": "estimate", "hand_back": "estimate"},
    ],
)
def test_the_other_settings_learn_too(settings: dict[str, Any]) -> None:
    learner = GSIIRL(problem_of(GAME, reward_scale=1.0), **settings)
    result = learner.fit(expert_of(GAME), ITERATIONS, TRAJECTORIES, progress=False)
    np.testing.assert_allclose(result.policy.sum(-1), 1.0, atol=1e-12)
    assert (result.policy[:, ~LEARNER_ACTIONS] == 0).all()
    assert np.isfinite(result.expert_reward.weights).all()
    assert np.abs(result.expert_reward.weights).max() > 0


@pytest.mark.slow
def test_the_textbook_game_is_committed_to() -> None:
    game = textbook(0.1)
    problem = problem_of(game, game=tabular(game))
    result = GSIIRL(problem).fit(expert_of(game), iterations=30, trajectories=100, progress=False)
    # No pure commitment earns more than 3, no equilibrium more than 2; the best commitment 3.267.
    assert learner_return(game, result.policy) >= 3.23
    evaluation = result.evaluate(game.expert)
    assert evaluation.deployed == pytest.approx(learner_return(game, result.policy), abs=1e-12)
    assert evaluation.ceiling == pytest.approx(3.267, abs=1e-3)
    assert evaluation.regret <= 0.03
    assert evaluation.marl < 2.5
    assert evaluation.sharp_marl < 2.5


# --- Evaluation ---


@pytest.mark.slow
def test_an_evaluation_holds_exact_returns_and_yardsticks(learned: Result) -> None:
    evaluation = learned.evaluate(GAME.expert)
    assert evaluation.deployed == pytest.approx(learner_return(GAME, learned.policy), abs=1e-12)
    assert evaluation.random == pytest.approx(learner_return(GAME, learned.played[0]), abs=1e-12)
    played = [learner_return(GAME, policy) for policy in learned.played]
    assert evaluation.played == pytest.approx(np.mean(played), abs=1e-12)
    assert evaluation.best_played == pytest.approx(max(played), abs=1e-12)
    assert evaluation.ceiling == pytest.approx(learner_return(GAME, evaluation.ceiling_policy), abs=1e-12)
    assert evaluation.floor < evaluation.random < evaluation.ceiling
    span = evaluation.ceiling - evaluation.floor
    assert evaluation.regret == pytest.approx((evaluation.ceiling - evaluation.deployed) / span, abs=1e-12)
    assert evaluation.undiscounted["deployed"] == pytest.approx(learner_return(GAME, learned.policy, 1.0), abs=1e-12)
    assert evaluation["regret"] == evaluation.regret
    assert set(evaluation) >= {"deployed", "ceiling", "floor", "regret", "marl", "sharp_marl"}
    # The best and the worst commitment, by a search of another kind.
    ceiling, _, floor = extremes(GAME, starts=32)
    assert evaluation.ceiling == pytest.approx(ceiling, abs=1e-3 * span)
    assert evaluation.floor == pytest.approx(floor, abs=1e-2 * span)


@pytest.mark.slow
def test_an_evaluation_depends_on_what_is_said_to_be_true(learned: Result) -> None:
    other = learned.evaluate(-GAME.expert, temperature=0.1)
    game = replace(GAME, expert=-GAME.expert, temperature=0.1)
    assert other.deployed == pytest.approx(learner_return(game, learned.policy), abs=1e-12)


@pytest.mark.slow
def test_several_results_are_evaluated_in_one_table(learned: Result) -> None:
    table = Results([learned, learned]).evaluate(GAME.expert)
    assert table["seed"].to_list() == [0, 0]
    assert table["deployed"][0] == pytest.approx(learner_return(GAME, learned.policy), abs=1e-12)


# --- Keeping and using a result; nothing here is compiled ---


@pytest.mark.slow
def test_a_learned_result_comes_back_from_its_folder(learned: Result, tmp_path: Path) -> None:
    learned.save(tmp_path / "result")
    loaded = load(tmp_path / "result", seed=0)
    same(loaded, learned)
    assert [loaded.act(0, 0, seed) for seed in range(20)] == [learned.act(0, 0, seed) for seed in range(20)]
    one, other = loaded.evaluate(GAME.expert), learned.evaluate(GAME.expert)
    assert {name: one[name] for name in one if name != "ceiling_policy"} == {
        name: other[name] for name in other if name != "ceiling_policy"
    }
    np.testing.assert_array_equal(one.ceiling_policy, other.ceiling_policy)


@pytest.mark.parametrize("features", [None, "table", "mapping"])
def test_a_saved_result_holds_its_problem(features: str | None, tmp_path: Path) -> None:
    table = np.stack([GAME.expert, np.ones(JOINT)], -1)
    settings: dict[str, Any] = {
        None: {},
        "table": {"expert_features": table, "dependent_features": table},
        "mapping": {"expert_features": {"toll": GAME.expert, "each step": np.ones(JOINT)}, "reward_scale": 2.0},
    }[features]
    before = made_result(problem_of(GAME, **settings), seed=4)
    with jax.enable_x64(False):
        before.save(tmp_path / "result")
        after = load(tmp_path / "result")
    same(after, before)
    assert (after.seed, after.trajectories) == (4, 20)
    assert list(after.expert_reward) == list(before.expert_reward)
    np.testing.assert_array_equal(after.expert_reward.table, before.expert_reward.table)
    np.testing.assert_array_equal(after.reached, before.reached)
    for one, other in zip(after.expert_reward.interval(0.8), before.expert_reward.interval(0.8), strict=True):
        np.testing.assert_array_equal(one, other)
    assert after.expert_reward.undetermined == before.expert_reward.undetermined
    one, other = before.problem, after.problem
    assert (one.temperature, one.discount, one.reward_scale) == (other.temperature, other.discount, other.reward_scale)
    for name in ("own_reward", "dependent_value", "game"):
        leaves = zip(jax.tree.leaves(getattr(one, name)), jax.tree.leaves(getattr(other, name)), strict=True)
        assert all(np.array_equal(a, b) and a.dtype == b.dtype for a, b in leaves)
    # Nothing in it is more than data.
    assert {path.name for path in (tmp_path / "result").iterdir()} == {
        "history.parquet",
        "result.json",
        "result.safetensors",
    }


def test_the_same_result_is_saved_as_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "other"):
        made_result().save(tmp_path / name)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "other" / path.name).read_bytes()


def test_actions_are_drawn_from_the_policy_with_numpy_alone() -> None:
    result = replace(made_result(), policy=np.broadcast_to([0.2, 0.8], (HORIZON, STATES, LEARNER)))
    with counted_compilations() as compiled:
        random = np.random.default_rng(0)
        drawn = [result.act(0, 0, random) for _ in range(4000)]
    assert not compiled
    assert all(isinstance(each, int) for each in drawn)
    assert np.mean(drawn) == pytest.approx(0.8, abs=5 * 0.4 / np.sqrt(4000))
    assert result.act(1, 0, 3) == result.act(1, 0, np.random.default_rng(3))
    key = jax.random.key(1)
    assert result.act(0, 0, key) == result.act(0, 0, key) == result.act(0, 0, jax.random.key_data(key))


def test_acting_where_the_game_never_arrives_warns() -> None:
    transitions = np.zeros((*JOINT, STATES))
    transitions[..., 0] = 1.0
    game = replace(GAME, transitions=transitions)
    result = made_result(problem_of(game))
    np.testing.assert_array_equal(result.reached, [[True, True, False], [True, False, False], [True, False, False]])
    with pytest.warns(FitWarning, match="state 1 was never to be met at step 2"):
        result.act(1, 2, 0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result.act(1, 0, 0)


def test_where_the_game_never_arrives_the_policy_is_uniform_over_what_is_allowed() -> None:
    transitions = np.zeros((*JOINT, STATES))
    transitions[..., 0] = 1.0
    problem = problem_of(replace(GAME, transitions=transitions))
    pure = np.broadcast_to([1.0, 0.0], (HORIZON, STATES, LEARNER))
    made = made_result(problem)
    result = Result.learned(
        problem=problem,
        seed=0,
        trajectories=20,
        policy=pure,
        expert_policy=made.expert_policy,
        expert_weights=made.expert_reward.weights,
        dependent_weights=made.dependent_reward.weights,
        draws=made.expert_reward.draws,
        history=made.history,
        played=made.played,
        answers=made.answers,
        effective_draws=1.0,
        sampled=False,
    )
    np.testing.assert_array_equal(result.policy[0, :2], [[1.0, 0.0], [1.0, 0.0]])
    np.testing.assert_array_equal(result.policy[1], [[1.0, 0.0], [1.0, 0.0], [0.5, 0.5]])


def test_one_cost_that_is_known_gives_the_unit_of_the_others() -> None:
    features = {"toll": GAME.expert, "each step": np.ones(JOINT)}
    reward = replace(made_result(problem_of(GAME, expert_features=features))).expert_reward
    reward.weights[:] = [3.0, -0.5]
    anchored = reward.anchored("each step", -2.0)
    assert dict(anchored) == {"toll": 12.0, "each step": -2.0}
    assert dict(reward) == {"toll": 3.0, "each step": -0.5}
    np.testing.assert_allclose(anchored.table, 12 * GAME.expert - 2, atol=1e-12)


def test_results_of_several_seeds_have_a_mean_and_a_spread() -> None:
    results = Results([made_result(seed=seed) for seed in (2, 3, 4)])
    assert len(results) == 3
    assert results[1].seed == 3
    assert results.mean["state 0, learner 0, expert 1"] == pytest.approx(4.0)
    assert results.spread["state 0, learner 0, expert 1"] == pytest.approx(1.0)
    assert Results([made_result()]).spread["state 0, learner 0, expert 1"] == 0.0
    assert repr(results).endswith("seeds 2 to 4)")


def test_a_run_that_is_still_exploring_at_its_end_warns() -> None:
    result = made_result()
    largest = np.ptp(GAME.dependent + GAME.own[..., None]) * (GAME.discount ** np.arange(HORIZON)).sum()
    lost = np.concatenate([np.full(10, largest), np.full(10, 0.06 * largest)])
    history = polars.DataFrame({"iteration": np.arange(20), "fit_decrement": np.full(20, 0.001), "played_loss": lost})
    with pytest.warns(FitWarning, match=r"seed 0: in the last 10 iterations .* earn \S+ less than the best one"):
        fit_module._warn(replace(result, history=history), 48)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fit_module._warn(replace(result, history=history.with_columns(played_loss=lost / 2)), 48)
        fit_module._warn(replace(result, history=history.head(15)), 48)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"fit_decrement": 0.5}, r"seed 0: .* has not converged"),
        ({"fit_decrement": float("nan")}, r"seed 0: .* has not converged"),
        ({"effective_draws": 2.0}, r"seed 0: .* far from Gaussian \(2\.0 of 48 draws"),
    ],
)
def test_a_fit_that_may_be_worse_than_it_looks_warns(changes: dict[str, float], said: str) -> None:
    history = polars.DataFrame({"iteration": [1], "fit_decrement": [changes.get("fit_decrement", 0.001)]})
    result = replace(made_result(), history=history, effective_draws=changes.get("effective_draws", 40.0))
    with pytest.warns(FitWarning, match=said):
        fit_module._warn(result, 48)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fit_module._warn(replace(result, history=made_result().history, effective_draws=40.0), 48)
