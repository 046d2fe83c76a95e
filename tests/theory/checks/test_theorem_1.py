import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.hypergradients import SPSA, HessianVectorCG, Implicit
from gsiirl.theory.checks.theorem_1 import (
    BOUNDED,
    DIRECT,
    IMPLICIT,
    PRINTED_DIRECT,
    PRINTED_SPSA,
    check,
    exponent,
    hypergradient,
    operations,
    small_game,
    small_point,
    small_program,
)
from gsiirl.theory.support.direct import Direct
from gsiirl.theory.support.games import SIZES, RandomProblem
from gsiirl.theory.support.printed_forms import printed_problem, recomputed
from gsiirl.theory.support.soft_joint_model import SoftJointModel


@pytest.fixture(scope="module")
def model() -> SoftJointModel:
    return SoftJointModel(RandomProblem.draw(3, SIZES[1]), 0.1)


@pytest.fixture(scope="module")
def point(model) -> tuple[jax.Array, jax.Array]:
    random = np.random.default_rng(0)
    sizes = model.instance.learner_features.shape[-1], model.instance.expert_features.shape[-1]
    learner, expert = (0.4 * random.normal(size=size) / np.sqrt(size) for size in sizes)
    return jnp.asarray(learner), jnp.asarray(expert)


@pytest.fixture(scope="module")
def found(model, point) -> dict[str, dict[str, jax.Array]]:
    """What both problems give, in one program."""

    def everything(learner, expert):
        printed = printed_problem(model, model.demonstrations(learner))
        ours = model.problem(learner, expert)
        return {
            "evaluations": {"printed": printed.evaluate(learner, expert), "ours": ours.evaluate(learner, expert)},
            "exact": {
                "printed": hypergradient(printed, Direct("frozen"), learner, expert),
                "ours": hypergradient(ours, Implicit("frozen"), learner, expert),
            },
            "spsa": {
                "printed": hypergradient(printed, SPSA("frozen"), learner, expert),
                "ours": hypergradient(ours, SPSA("frozen"), learner, expert),
            },
        }

    return jax.jit(everything)(*point)


def test_walking_afresh_gives_what_one_sweep_gives():
    random = np.random.default_rng(1)
    horizon, states, discount = 5, 3, 0.9
    transitions = random.dirichlet(np.ones(states), size=(horizon, states))
    increments = random.normal(size=(horizon, states, 2))
    starts = np.broadcast_to(np.eye(states), (horizon, states, states))
    expected, following = np.zeros((horizon, states, 2)), np.zeros((states, 2))
    for time in reversed(range(horizon)):
        following = expected[time] = increments[time] + discount * transitions[time] @ following
    tables = jnp.asarray(transitions), jnp.asarray(increments)
    np.testing.assert_allclose(recomputed(jnp.asarray(starts), *tables, discount), expected, rtol=1e-12)
    initial = random.dirichlet(np.ones(states))
    from_start = recomputed(jnp.asarray(initial)[None, None], *tables, discount)
    np.testing.assert_allclose(from_start[0, 0], initial @ expected[0], rtol=1e-12)


def test_printed_evaluations_are_right(found):
    (printed_objective, printed_gradient), (objective, gradient) = found["evaluations"].values()
    np.testing.assert_allclose(printed_objective, objective, rtol=1e-10)
    np.testing.assert_allclose(printed_gradient, gradient, rtol=1e-10, atol=1e-12)


def test_printed_direct_form_is_the_exact_hypergradient(found):
    np.testing.assert_allclose(found["exact"]["printed"], found["exact"]["ours"], rtol=1e-10)


def test_printed_spsa_draws_what_ours_draws(found):
    # Differences over 2p lose a few digits of the sums.
    np.testing.assert_allclose(found["spsa"]["printed"], found["spsa"]["ours"], rtol=1e-8)


@pytest.mark.parametrize(
    ("name", "expected"),
    [(PRINTED_DIRECT, 3.0), (PRINTED_SPSA, 2.0), *((name, 1.0) for name in (*BOUNDED, DIRECT))],
)
def test_counted_exponents(name, expected):
    # Far enough that the T² and T³ are not hidden by what is linear in T: counting runs nothing.
    counted = {horizon: float(operations(small_program(name, horizon)).total) for horizon in (256, 512)}
    assert exponent(counted) == pytest.approx(expected, abs=0.08)


def test_no_count_of_ours_hides_a_conditional():
    for name in (*BOUNDED, DIRECT):
        assert operations(small_program(name, 4)).conditionals == 0
    assert operations(small_program(IMPLICIT, 4)).while_loops == 0


def test_conjugate_gradients_take_no_more_steps_than_are_counted():
    model, estimator = small_game(16), HessianVectorCG("frozen")

    def evaluations(learner, expert):
        problem, key = model.problem(learner, expert), jax.random.key(0)
        return estimator.estimate(problem, learner, expert, None, key, jnp.asarray(0))[0].evaluations

    point = small_point()
    products = (int(jax.jit(evaluations)(*point)) - 2) / 2
    assert point[1].size <= products <= 2 * point[1].size


def test_exponent_of_a_power_is_its_exponent():
    assert exponent({horizon: 3.0 * horizon**2 for horizon in (8, 64, 512)}) == pytest.approx(2.0)
    assert exponent({horizon: 5.0 * horizon**3 for horizon in (8, 16, 32)}) == pytest.approx(3.0)


@pytest.mark.slow
def test_every_bound_but_those_on_times_is_kept():
    finding = check(quick=True)
    assert [each.name for each in finding.missed if "time" not in each.name] == []
    assert {curve.role for panel in finding.panels for curve in panel.curves} == {"ours", "paper", "guide"}
