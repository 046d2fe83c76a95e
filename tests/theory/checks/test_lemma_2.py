"""The check of Lemma 2 on games small enough for tests, under the model that compiles fast."""

import jax.numpy as jnp
import pytest

from gsiirl.theory.checks import lemma_2
from gsiirl.theory.checks.lemma_2 import ESTIMATORS, IMPLICIT
from gsiirl.theory.support.brute_force import Case, Measured
from gsiirl.theory.support.games import Size

SIZE = Size(states=3, learner_actions=2, expert_actions=2, horizon=3, learner_parameters=3, expert_parameters=2)


def case(regularisation: float = 0.1, **settings) -> Case:
    return Case.draw(0, SIZE, regularisation, forward_model="soft_joint", **settings)


@pytest.fixture(scope="module")
def inside() -> Measured:
    return Measured(case())


@pytest.fixture(scope="module")
def sphere() -> Measured:
    return Measured(case(true_norm=2.5, regularisation=1e-3))


def test_lemma_2_is_the_derivative_inside_and_on_the_sphere(inside, sphere):
    assert not inside.brute.lower.active
    assert sphere.brute.lower.active
    for at in (inside, sphere):
        assert at.brute.lower.residual <= 1e-12
        for estimator in ESTIMATORS.values():
            assert at.error(at.estimate(estimator).value) <= 1e-5
        assert at.response_error() <= 1e-4
        # The bound above means something only where the response is felt.
        assert at.error(at.estimate(IMPLICIT).through_learner) > 1e-3
        assert at.error(at.estimate(IMPLICIT, frozen=True).value) > 1e-2
        assert at.response_error(frozen=True) > 0.1
    assert sphere.response_error(with_multiplier=False) > 0.01


def test_asymmetry():
    assert lemma_2.asymmetry(jnp.asarray([[1.0, 2.0], [2.0, 3.0]])) == 0.0
    assert lemma_2.asymmetry(jnp.asarray([[0.0, 1.0], [-1.0, 1.0]])) == pytest.approx(2.0**0.5)


def test_the_check_holds_and_draws_what_it_says(monkeypatch: pytest.MonkeyPatch):
    drawn = Case.draw.__func__

    def draw(cls: type[Case], seed: int, size: Size, *arguments, **settings) -> Case:
        return drawn(cls, seed, size, *arguments, **(settings | {"forward_model": "soft_joint"}))

    monkeypatch.setattr(Case, "draw", classmethod(draw))
    monkeypatch.setattr(lemma_2, "SIZES", (SIZE,))
    finding = lemma_2.check(quick=True)
    assert finding.missed == []
    bounded = [each for each in finding.measurements if each.holds is not None]
    # Both places, every estimator, the lower level without a likelihood, and a reward outside the class.
    names = " ".join(each.name for each in bounded if "worst relative error of ∇f" in each.name)
    for part in ("inside", "on the sphere", "`equilibrium`", "outside the reward class", *lemma_2.ESTIMATORS):
        assert part in names
    for panel in finding.panels:
        errors = {curve.name: curve.y for curve in panel.curves}
        assert max(errors["measured"]) <= 1e-5
        assert errors["well_specified"][0] < errors["well_specified"][-1]
        assert min(errors["demonstrations held fixed (the paper)"]) > max(errors["measured"])
