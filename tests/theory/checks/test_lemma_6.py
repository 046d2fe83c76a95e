"""The check of Lemma 6: enumeration and sampling on problems whose answers are known."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.hypergradients import BilevelProblem
from gsiirl.theory.checks import lemma_6
from gsiirl.theory.checks.lemma_6 import Point, all_signs, point_number, sampled_estimates
from gsiirl.theory.support.brute_force import Case
from gsiirl.theory.support.games import Size

SIZE = Size(states=3, learner_actions=2, expert_actions=2, horizon=3, learner_parameters=3, expert_parameters=2)


@pytest.fixture
def point() -> Point:
    """A game under the model that compiles fast."""
    case = Case.draw(0, SIZE, 0.1, forward_model="soft_joint")
    return Point(case.game, case.commitment, case.believed)


def test_all_signs_are_all_there_once():
    signs = all_signs(3)
    assert signs.shape == (8, 3)
    assert len(np.unique(signs, axis=0)) == 8
    assert set(signs.ravel()) == {-1.0, 1.0}


@pytest.mark.slow
def test_the_enumerated_bias_is_that_of_cubes(monkeypatch: pytest.MonkeyPatch, point: Point):
    # For Σ x_i³ central differences along Δ give Σ (3x_i² + p²)Δ_i: p² too much in every entry, and nothing else.
    def evaluate(learner: jax.Array, expert: jax.Array) -> tuple[jax.Array, jax.Array]:
        return jnp.sum(learner**3) + jnp.sum(expert**3), expert**3 + jnp.sum(learner**3) * jnp.ones_like(expert)

    monkeypatch.setattr(lemma_6, "exact_problem", lambda game: BilevelProblem(evaluate, 0.0))
    learner, expert = point.learner, point.expert
    with jax.disable_jit():
        estimates = lemma_6.all_estimates(point, jnp.asarray(0.3))
        exact = lemma_6.exact_factors(point)
    bias = jax.tree.map(lambda found, truth: found.mean(axis=0) - truth[0], estimates, exact)
    assert np.allclose(exact.learner_gradient, 3.0 * learner[None, :] ** 2)
    assert np.allclose(exact.hessian, jnp.diag(3.0 * expert**2)[None])
    assert np.allclose(bias.learner_gradient, 0.09, rtol=0.0, atol=1e-12)
    assert np.allclose(bias.expert_gradient, 0.09, rtol=0.0, atol=1e-12)
    assert np.allclose(bias.hessian, 0.09 * np.eye(2), rtol=0.0, atol=1e-12)
    assert np.allclose(bias.mixed, 0.09, rtol=0.0, atol=1e-12)
    # Every Δ occurs equally often; Δ and −Δ give one estimate.
    counts = np.unique(np.round(estimates.learner_gradient, 9), axis=0, return_counts=True)[1]
    assert counts.tolist() == [2, 2, 2, 2]


def test_points_have_numbers_of_their_own():
    random = np.random.default_rng(0)
    learners = jnp.asarray(random.normal(size=(500, 3)))
    experts = jnp.zeros((500, 2))
    numbers = jax.vmap(point_number)(learners, experts)
    assert len(np.unique(numbers)) == 500
    assert np.array_equal(numbers, jax.vmap(point_number)(learners, experts))
    # A point and its reflection differ in the sign bit alone.
    assert not np.any(numbers == jax.vmap(point_number)(-learners, experts))


@pytest.mark.slow
def test_sampled_estimates_scatter_around_the_exact_ones(point: Point):
    keys = jax.random.split(jax.random.key(1), 300)
    reach = jnp.asarray(0.3)
    exact = lemma_6.all_estimates(point, reach)
    for common in (0.0, 1.0):
        found = sampled_estimates(point, reach, keys, jnp.asarray(common))
        for name in lemma_6.NAMES:
            values = np.asarray(getattr(found, name)).reshape(len(keys), -1)
            truth = np.asarray(getattr(exact, name)).mean(axis=0).ravel()
            error = values.std(axis=0) / len(keys) ** 0.5
            assert np.all(np.abs(values.mean(axis=0) - truth) <= 4.5 * error)


@pytest.mark.slow
def test_common_random_numbers_help_and_more_so_for_small_perturbations(point: Point):
    keys = jax.random.split(jax.random.key(2), 300)

    def variance(reach: float, common: float) -> float:
        found = sampled_estimates(point, jnp.asarray(reach), keys, jnp.asarray(common))
        return float(np.var(found.learner_gradient, axis=0).sum())

    assert variance(0.003, 0.0) / variance(0.03, 0.0) == pytest.approx(100.0, rel=0.4)
    assert variance(0.003, 1.0) < 0.1 * variance(0.003, 0.0)


def test_biases_are_relative_and_of_second_order(point: Point):
    bias = lemma_6.biases(point, [0.02, 0.04])
    for values in bias.values():
        assert values[1] / values[0] == pytest.approx(4.0, rel=0.1)
        assert values[0] < 0.05
