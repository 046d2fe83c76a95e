import numpy as np
import pytest

import gsiirl
from gsiirl.errors import InputError
from gsiirl.experiments.config import load_config
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.experiments.security.problem import build
from gsiirl.experts.continuous_expert import ContinuousRespondingExpert
from gsiirl.problems.continuous_problem import ContinuousProblem
from gsiirl.problems.problem import Problem


def test_a_named_network_is_a_problem_and_its_attacker() -> None:
    problem, attacker = gsiirl.problems.security("small-linear", horizon=4, temperature=0.2)
    assert isinstance(problem, Problem)
    assert isinstance(attacker, gsiirl.RespondingExpert)
    assert (problem.game.horizon, problem.temperature, attacker.temperature) == (4, 0.2, 0.2)
    assert problem.game is attacker.game
    # As `gsiirl run security` has it.
    config = load_config(SecurityConfig, {"graph": "small-linear", "horizon": 4, "temperature": 0.2}).resolved()
    same = build(config, config.network())
    np.testing.assert_array_equal(attacker.reward.dense(), same.expert.reward.dense())
    np.testing.assert_array_equal(problem.dependent_value.dense(), same.bilevel.accessed.dense())


def test_without_a_name_the_network_is_a_random_one() -> None:
    first, _ = gsiirl.problems.security(nodes=4, edges=5)
    other, _ = gsiirl.problems.security(nodes=4, edges=5, graph_seed=1)
    assert first.game.number_of_actions.learner == 5
    assert not np.array_equal(first.dependent_value.dense(), other.dependent_value.dense())


@pytest.mark.parametrize("name", ["crossing", "deception"])
def test_a_continuous_problem_comes_with_its_expert(name: str) -> None:
    problem, expert = getattr(gsiirl.problems, name)(horizon=7)
    assert isinstance(problem, ContinuousProblem)
    assert isinstance(expert, ContinuousRespondingExpert)
    assert (problem.game.horizon, expert.solver.game.horizon) == (7, 7)


def test_what_the_learner_is_told_does_not_hold_the_experts_reward() -> None:
    problem, attacker = gsiirl.problems.security("small-linear")
    assert isinstance(problem, Problem)
    true = np.asarray(attacker.reward.dense())
    held = [value.dense() for value in (problem.own_reward, problem.dependent_value)]
    assert not any(np.array_equal(np.asarray(each), true) for each in held)


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("security", {"graph": "nope"}, "graph: 'nope' is unknown; give one of"),
        ("security", {"temprature": 1.0}, "temprature: is no field of the security experiment; did you mean temp"),
        ("crossing", {"horizon": 0}, "horizon: cannot be 0; give a whole number of at least 1"),
        ("deception", {"variant": "x"}, "variant: cannot be x; choose mpe or separate_target"),
    ],
)
def test_an_unknown_name_or_setting_is_refused(name: str, settings: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        getattr(gsiirl.problems, name)(**settings)


def test_there_is_no_other_named_problem() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'chess'"):
        getattr(gsiirl.problems, "chess")  # noqa: B009 (a type checker knows that it is none)
    assert set(dir(gsiirl.problems)) == {"crossing", "deception", "security"}
