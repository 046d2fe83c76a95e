"""The front door of continuous games: what `GSIIRL.fit` gives back, what it depends on, and what it does not."""

import ast
import dataclasses
import inspect
import operator
import warnings
from dataclasses import MISSING, fields
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from small_continuous_games import (
    ITERATIONS,
    PROBLEM,
    TRAJECTORIES,
    Line,
    LineState,
    cat,
    cat_reward,
    line_learner,
    unlearned,
)
from small_games import counted_compilations

from gsiirl import GSIIRL, FitWarning
from gsiirl.equilibria.pathwise import Pathwise, policies_of
from gsiirl.experiments.continuous.config import ContinuousConfig
from gsiirl.front_door import continuous_fit as fit_module
from gsiirl.front_door.continuous_fit import ContinuousGSIIRL
from gsiirl.front_door.continuous_result import ContinuousResult, ContinuousResults, LearnedTransitionReward
from gsiirl.games.rollout import episodes_from, initial_states
from gsiirl.interaction import Proposal
from gsiirl.problems.continuous_problem import single_precision
from gsiirl.types import Sides, Transition

GAME = Line()


def fit(expert: Any = None, seed: int = 0, learner: ContinuousGSIIRL | None = None, **settings: Any) -> Any:
    """Every fit of one and the same shape."""
    door = learner or line_learner()
    return door.fit(expert or cat(), ITERATIONS, TRAJECTORIES, seed, progress=False, **settings)


@pytest.fixture(scope="module")
def learned() -> ContinuousResult:
    return fit()


def same(one: ContinuousResult, other: ContinuousResult) -> None:
    """See that two results are the same to the last bit."""
    for mine, theirs in zip(
        jax.tree.leaves((one.policy, one.expert_policy)),
        jax.tree.leaves((other.policy, other.expert_policy)),
        strict=True,
    ):
        np.testing.assert_array_equal(mine, theirs)
    np.testing.assert_array_equal(one.expert_reward.weights, other.expert_reward.weights)
    np.testing.assert_array_equal(one.dependent_reward.weights, other.dependent_reward.weights)
    assert one.history.equals(other.history)


class Habitual:
    """Somebody's own cat: it goes home as fast as it can, whatever the robot does, and keeps what it was asked."""

    def __init__(self) -> None:
        self.asked: list[tuple[int, Any]] = []

    def demonstrate(self, learner_policy: Any, number: int, key: Any) -> Transition:
        self.asked.append((number, learner_policy))
        starts = initial_states(GAME, key, number)
        return episodes_from(GAME, Sides(learner_policy, lambda seen, time: jnp.ones(1)), starts)


class Closed:
    """Has the library's own cat show something, and is unhappy when anybody asks for anything else."""

    def __init__(self) -> None:
        self.cat = cat()
        self.habits: Any = None

    def __getattribute__(self, name: str) -> Any:
        caller = inspect.stack()[1].function
        assert name in ("demonstrate", "__class__") or caller in ("__init__", "demonstrate"), f"asked for {name}"
        return super().__getattribute__(name)

    def demonstrate(self, learner_policy: Any, number: int, key: Any) -> Transition:
        if self.habits is None:
            self.habits = self.cat.init(jax.random.key(0), learner_policy)
        self.habits, met = self.cat.meet(self.habits, Proposal(learner_policy), number, key)
        return met.demonstrations


@pytest.mark.slow
def test_what_an_own_expert_shows_of_another_world_and_policy_gives_a_warning_each() -> None:
    class Slower(Habitual):
        """Takes a tenth less than a full step, while the robot does as it likes."""

        def demonstrate(self, learner_policy: Any, number: int, key: Any) -> Transition:
            seen = super().demonstrate(lambda seen, time: jnp.full(1, 0.7), number, key)
            return dataclasses.replace(seen, actions=Sides(seen.actions.learner, 0.9 * seen.actions.expert))

    with pytest.warns(FitWarning) as said:
        fit(Slower())
    doubts = [each for each in said if "demonstrations" in str(each.message)]
    assert [str(each.message).split()[0] for each in doubts] == [
        "demonstrations.following.cat",
        "demonstrations.actions.learner",
    ]
    assert {each.filename for each in doubts} == {__file__}


# --- What comes back ---


@pytest.mark.slow
def test_a_result_holds_policies_rewards_and_a_row_an_iteration(learned: ContinuousResult) -> None:
    assert type(learned) is ContinuousResult
    assert list(learned.expert_reward) == ["home", "away"]
    # The expert's weights are on the sphere of their scale, and those of r_ld are fitted to values that are read.
    assert np.linalg.norm(learned.expert_reward.weights) == pytest.approx(2.0, abs=1e-5)
    assert learned.dependent_reward["apart"] == pytest.approx(0.5, abs=1e-3)
    history = learned.history
    assert history["iteration"].to_list() == [1, 2, 3, 4]
    assert history["expert_trajectories"].to_list() == [5, 10, 15, 20]
    assert history["exploring"].to_list() == [False, False, True, False]
    assert np.isfinite(history["earned"].to_numpy()).all()
    assert history["reward_change"].null_count() == 1


@pytest.mark.slow
def test_the_action_is_that_of_the_policy_at_the_share_of_the_episode_that_is_over(learned: ContinuousResult) -> None:
    state = LineState(jnp.asarray(0.3), jnp.asarray(-0.4))
    for t in range(GAME.horizon):
        expected = learned.policy(np.array([0.3, -0.4], np.float32), t / GAME.horizon)
        action = learned.act(state, t, jax.random.key(t))
        assert isinstance(action, np.ndarray)
        np.testing.assert_allclose(action, expected, atol=1e-6)


@pytest.mark.slow
def test_settling_goes_on_from_what_the_iterations_came_to(learned: ContinuousResult) -> None:
    settled = fit(learner=line_learner(settling_steps=3))
    np.testing.assert_array_equal(settled.expert_reward.weights, learned.expert_reward.weights)
    moved = [
        np.abs(one - other).max()
        for one, other in zip(*map(jax.tree.leaves, (settled.policy, learned.policy)), strict=True)
    ]
    assert 0 < max(moved) < 0.1


@pytest.mark.slow
def test_an_evaluation_holds_returns_of_both_sides(learned: ContinuousResult) -> None:
    told = learned.evaluate(cat_reward, training_steps=40, evaluation_episodes=200)
    again = learned.evaluate(cat_reward, training_steps=40, evaluation_episodes=200)
    assert dict(told) == dict(again)
    for name in ("deployed", "marl", "random"):
        assert told.undiscounted[name] < told[name] < 0
        assert told.expert_undiscounted[name] < told.expert[name] < 0
    # The cat that answers goes home, as near as its small network has come to it; one that stays does not.
    assert told.expert_undiscounted["deployed"] > -2.0
    assert learned.evaluate(lambda seen: -cat_reward(seen), training_steps=40).expert["deployed"] > 0


# --- What it depends on, and what it does not ---


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes_in_either_precision_and_another_seed_others(
    learned: ContinuousResult,
) -> None:
    with jax.enable_x64(False):
        same(fit(), learned)
    assert not np.array_equal(fit(seed=1).expert_reward.weights, learned.expert_reward.weights)


@pytest.mark.slow
def test_another_fit_of_the_same_shape_compiles_nothing(learned: ContinuousResult) -> None:
    assert learned.seed == 0
    learner, another = line_learner(), cat()
    learner.fit(cat(), ITERATIONS, TRAJECTORIES, progress=False)
    with counted_compilations() as compiled:
        learner.fit(another, ITERATIONS, TRAJECTORIES, seed=5, progress=False)
    assert not compiled


@pytest.mark.slow
def test_several_seeds_at_once_are_one_after_the_other(learned: ContinuousResult) -> None:
    together = fit(seeds=2, seed=0)
    assert isinstance(together, ContinuousResults)
    assert [each.seed for each in together] == [0, 1]
    np.testing.assert_allclose(together[0].expert_reward.weights, learned.expert_reward.weights, atol=1e-3)
    assert together.mean["home"] == pytest.approx(np.mean([each.expert_reward["home"] for each in together]))


@pytest.mark.slow
def test_somebodys_own_expert_is_asked_once_a_round_with_a_policy_that_it_can_play() -> None:
    expert = Habitual()
    result = fit(expert)
    assert [number for number, _ in expert.asked] == [TRAJECTORIES] * ITERATIONS
    assert expert.asked[0][1](np.zeros(2, np.float32), 0.0).shape == (1,)
    # A cat that always walks to the right likes to be there.
    with single_precision():
        home, away = (float(result.expert_reward(at(place))) for place in (1.0, -1.0))
    assert home > away


@pytest.mark.slow
def test_nothing_of_an_expert_is_looked_at_but_what_it_shows() -> None:
    assert np.isfinite(fit(Closed()).expert_reward.weights).all()


def at(place: float) -> Transition:
    """The cat stands at `place`, with the robot far away."""
    state = LineState(jnp.asarray(9.0, jnp.float32), jnp.asarray(place, jnp.float32))
    return Transition(state, Sides(jnp.zeros(1), jnp.zeros(1)), state)


# --- What a learner is made of; nothing here is compiled ---


def test_the_defaults_are_those_of_the_command_line() -> None:
    flags = {each.name: each.default for each in fields(ContinuousConfig)}
    own = {each.name: each.default for each in fields(ContinuousGSIIRL) if each.kw_only}
    assert MISSING not in own.values()
    # Pydantic keeps a field's default in its `Field`.
    assert own == {name: getattr(flags[name], "default", flags[name]) for name in own}


def test_a_type_checker_is_told_of_every_setting() -> None:
    [door] = [
        each
        for each in ast.walk(ast.parse(inspect.getsource(inspect.getmodule(GSIIRL))))  # pyright: ignore[reportArgumentType]
        if isinstance(each, ast.FunctionDef) and each.name == "__new__" and each.args.kwonlyargs
    ]
    told = {each.arg: ast.unparse(each.annotation) for each in door.args.kwonlyargs if each.annotation}
    assert told == {each.name: each.type.__name__ for each in fields(ContinuousGSIIRL) if each.kw_only}  # pyright: ignore[reportAttributeAccessIssue]


def test_nothing_that_is_passed_to_the_learner_can_hold_the_experts_reward() -> None:
    learner = line_learner().learner(ITERATIONS, TRAJECTORIES)
    functions = [leaf for leaf in jax.tree.leaves(learner, is_leaf=callable) if callable(leaf)]
    assert PROBLEM.own_reward in functions
    assert cat_reward not in functions


def test_the_rates_fall_over_all_steps_and_as_many_episodes_are_compared_as_there_are() -> None:
    learner = line_learner(compared=30, model_rate=0.5).learner(iterations=10, trajectories=7)
    assert (learner.compared, learner.responder.batch, learner.solver.batch) == (7, 7, 4)
    with single_precision():
        state = learner.solver.init(jax.random.key(0)).learner
        gradient = jax.tree.map(jnp.ones_like, state.policy)
        sizes, update = [], jax.jit(learner.solver.optimiser.learner.update)
        for _ in range(25):
            step, remembered = update(gradient, state.optimiser)
            state = dataclasses.replace(state, optimiser=remembered)
            sizes.append(float(jnp.abs(jax.tree.leaves(step)[0]).max()))
    # Adam's step along a gradient that stays is its rate: 0.01 at first, and a tenth after 10 iterations of 2 steps.
    assert sizes[0] == pytest.approx(0.01, rel=1e-3)
    assert sizes[20:] == pytest.approx([0.001] * 5, rel=1e-3)


def test_what_settling_comes_to_is_handed_back_where_there_are_steps_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    key, rewards = jax.random.key(0), Sides(PROBLEM.own_reward, cat_reward)
    other, asked = unlearned(1), []
    found = Sides(other.policy, other.expert_policy)
    monkeypatch.setattr(Pathwise, "settle", lambda _, *arguments: asked.append(arguments) or found)
    with single_precision():
        solution = line_learner().solver(1, 0.1).init(key)
    before = jax.tree.leaves(policies_of(solution))
    assert all(map(operator.is_, jax.tree.leaves(line_learner().settled(solution, rewards, key)), before))
    assert not asked
    assert line_learner(settling_steps=3).settled(solution, rewards, key) is found
    [(policies, under, _, steps)] = asked
    assert all(map(operator.is_, jax.tree.leaves(policies), before))
    assert (under, steps) == (rewards, 3)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"dependent_reward": LearnedTransitionReward(PROBLEM.dependent_reward, np.array([1.0]))},
            "seed 0: the weights of r_ld are at their bound; a larger dependent_scale helps",
        ),
        (
            {"expert_reward": LearnedTransitionReward(PROBLEM.expert_reward, np.array([np.nan, 1.0]))},
            "seed 0: what was learned is not finite",
        ),
    ],
)
def test_a_fit_that_is_worse_than_it_looks_warns(changes: dict[str, Any], said: str) -> None:
    with pytest.warns(FitWarning, match=said):
        fit_module._warn(unlearned(**changes))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fit_module._warn(unlearned())


# --- Using a result ---


def test_rewards_are_mappings_of_names_and_functions_of_a_step() -> None:
    reward = unlearned().expert_reward
    assert dict(reward) == pytest.approx({"home": 1.2, "away": -1.6})
    with pytest.raises(KeyError):
        reward["elsewhere"]
    # -1.2 (1 − 0)² + 1.6 (−1 − 0)²
    with single_precision():
        assert float(reward(at(0.0))) == pytest.approx(0.4, abs=1e-6)
    assert repr(reward) == "LearnedTransitionReward(2 weights, -1.6 to 1.2)"


def test_results_of_several_seeds_have_a_mean_and_a_spread() -> None:
    results = ContinuousResults([unlearned(seed) for seed in (0, 1)])
    assert results[1].seed == 1
    assert [each.seed for each in results[:1]] == [0]
    assert results.mean["away"] == pytest.approx(-0.6)
    assert results.spread["away"] == pytest.approx(2 / 2**0.5)
    assert repr(results) == f"ContinuousResults({PROBLEM!r}, seeds 0 to 1)"
    assert repr(results[0]) == f"ContinuousResult({PROBLEM!r}, seed 0, 1 iterations of 20)"
