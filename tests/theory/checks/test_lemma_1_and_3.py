import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.hypergradients import FiniteDifference, HessianVectorCG, Implicit
from gsiirl.theory.checks import lemma_1_and_3
from gsiirl.theory.checks.lemma_1_and_3 import LEMMA_1, LEMMA_3, OURS, Game
from gsiirl.theory.support.direct import Direct
from gsiirl.theory.support.games import SIZES

SIZE = 1
"""The one of SIZES with n = m, where the orientation of the mixed derivative shows."""


@pytest.mark.parametrize("nonlinear", [False, True])
def test_corrected_formulas_are_the_derivatives_and_printed_ones_are_not(nonlinear):
    ours, printed, _ = Game.draw(0, SIZE, nonlinear).compare()
    assert ours.keys() == OURS.keys()
    assert max(ours.values()) <= 1e-10
    assert printed.keys() == LEMMA_1.keys() | LEMMA_3.keys()
    assert min(printed.values()) > 5e-3


def test_at_temperature_one_only_what_lacks_the_temperature_becomes_right():
    printed = Game.draw(0, SIZE, nonlinear=True).at_temperature(1.0).compare().printed
    right = {"no_temperature", "expert_gradient", "mixed"}
    assert max(printed[key] for key in right) <= 1e-10
    assert min(error for key, error in printed.items() if key not in right) > 5e-3


def test_the_check_holds_and_draws_every_formula(monkeypatch):
    monkeypatch.setattr(lemma_1_and_3, "SIZES", (SIZES[SIZE],) * len(SIZES))
    finding = lemma_1_and_3.check(quick=True)
    assert finding.holds
    assert sum(each.holds is not None for each in finding.measurements) == 2 * len(OURS) + 1
    assert [len(panel.curves) for panel in finding.panels] == [1 + len(LEMMA_1), 1 + len(LEMMA_3)]


@eqx.filter_jit
def estimates(game_model, learner_parameters, expert_parameters):
    """∇f by every exact estimator, and what the last one, conjugate gradients, reports."""
    problem = game_model.problem(learner_parameters, expert_parameters)
    estimators = Implicit("measured"), Direct("measured"), FiniteDifference("measured"), HessianVectorCG("measured")
    found = [
        each.estimate(problem, learner_parameters, expert_parameters, None, jax.random.key(0), jnp.asarray(0))[0]
        for each in estimators
    ]
    return [each.value for each in found], found[-1]


def distance(found, exact) -> float:
    return float(jnp.linalg.norm(found - exact) / jnp.linalg.norm(exact))


@pytest.mark.parametrize("nonlinear", [False, True])
def test_estimators_agree_on_the_model(nonlinear):
    game = Game.draw(1, SIZE, nonlinear)
    (exact, direct, differences, products), report = estimates(game.model, game.learner, game.expert)
    assert distance(direct, exact) <= 1e-9
    assert distance(differences, exact) <= 1e-5
    if game.compare().smallest_eigenvalue > 0.0:
        assert distance(products, exact) <= 1e-5
    else:
        # L is not convex here: conjugate gradients have nothing to find, and must not pretend that they have.
        assert float(report.smallest_eigenvalue) < 0.0
        assert float(report.linear_residual) > 1e-3


def test_the_likelihood_is_convex_for_linear_rewards_alone():
    linear, nonlinear = (Game.draw(1, SIZE, kind).compare().smallest_eigenvalue for kind in (False, True))
    assert linear > 0.0
    assert nonlinear < -lemma_1_and_3.REGULARISATION


def test_demonstrations_move_as_their_jacobian_says():
    game = Game.draw(2, SIZE, nonlinear=True)
    model, step = game.model, 1e-5

    @eqx.filter_jit
    def expectation(learner_parameters):
        return model.expert_expectation(model.demonstrations(learner_parameters), game.expert)

    moves = step * jnp.eye(SIZES[SIZE].learner_parameters)
    columns = [(expectation(game.learner + move) - expectation(game.learner - move)) / (2.0 * step) for move in moves]
    found = eqx.filter_jit(lambda: model.problem(game.learner, game.expert))()
    expected = jnp.stack(columns, axis=1) / model.temperature
    assert found.demonstration_jacobian is not None
    np.testing.assert_allclose(found.demonstration_jacobian, expected, rtol=1e-6, atol=1e-8)
