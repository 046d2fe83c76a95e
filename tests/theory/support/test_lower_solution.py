import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import minimize

from gsiirl.theory.support.lower_solution import LowerSolution, solve_lower


@jax.jit
def quadratic(matrix: jax.Array, centre: jax.Array, start: jax.Array) -> LowerSolution:
    """The minimiser of a quadratic around `centre`."""
    return solve_lower(lambda theta: matrix @ (theta - centre), start)


@jax.jit
def log_sum_exp(features: jax.Array, demonstrated: jax.Array, start: jax.Array) -> LowerSolution:
    """The maximum-likelihood fit of a softmax, regularised: strictly convex and not quadratic."""
    return solve_lower(lambda theta: jax.grad(_softmax_loss)(theta, features, demonstrated), start)


def _softmax_loss(theta: jax.Array, features: jax.Array, demonstrated: jax.Array) -> jax.Array:
    return jax.nn.logsumexp(features @ theta) - jnp.vdot(demonstrated, theta) + 5e-4 * jnp.vdot(theta, theta)


def positive(random: np.random.Generator) -> np.ndarray:
    factor = random.normal(size=(4, 4))
    return factor @ factor.T + 0.1 * np.eye(4)


@pytest.mark.parametrize("seed", range(4))
def test_inside_the_ball_it_is_the_root(seed):
    random = np.random.default_rng(seed)
    centre = random.normal(size=4)
    centre *= 0.9 / np.linalg.norm(centre)
    # A matrix that is not symmetric belongs to no L: the root is sought all the same.
    matrix = positive(random) + np.triu(random.normal(size=(4, 4)), 1) * 0.1
    found = quadratic(jnp.asarray(matrix), jnp.asarray(centre), jnp.asarray(random.normal(size=4)))
    assert np.allclose(found.parameters, centre, rtol=0.0, atol=1e-12)
    assert not found.active
    assert found.residual <= 1e-12
    assert found.constraint.multiplier == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_on_the_sphere_the_gradient_points_inwards(seed):
    random = np.random.default_rng(seed)
    centre, matrix = 2.0 * random.normal(size=4), positive(random)
    centre *= 1.6 / np.linalg.norm(centre)
    found = quadratic(jnp.asarray(matrix), jnp.asarray(centre), jnp.zeros(4))
    theta, gradient = np.asarray(found.parameters), matrix @ (np.asarray(found.parameters) - centre)
    assert np.linalg.norm(theta) == pytest.approx(1.0, abs=1e-15)
    assert found.active
    assert found.constraint.multiplier > 0.0
    assert np.allclose(gradient, -float(found.constraint.multiplier) * theta, rtol=0.0, atol=1e-12)
    assert found.residual <= 1e-12


@pytest.mark.parametrize(("seed", "sharpness"), [(0, 1.0), (1, 1.0), (2, 5.0), (3, 5.0), (4, 5.0)])
def test_far_from_quadratic_it_agrees_with_scipy(seed, sharpness):
    random = np.random.default_rng(seed)
    features = sharpness * random.normal(size=(6, 4))
    demonstrated = random.dirichlet(np.ones(6)) @ features
    # Seeds 1 and 3 end on the sphere.
    found = log_sum_exp(jnp.asarray(features), jnp.asarray(demonstrated), jnp.full(4, 0.5))
    loss = jax.jit(jax.value_and_grad(_softmax_loss))
    constraint = {"type": "ineq", "fun": lambda theta: 1.0 - theta @ theta, "jac": lambda theta: -2.0 * theta}
    expected = minimize(
        lambda theta: [np.asarray(part) for part in loss(theta, features, demonstrated)],
        np.zeros(4),
        jac=True,
        method="SLSQP",
        constraints=[constraint],
        options={"ftol": 1e-15, "maxiter": 300},
    )
    assert np.allclose(found.parameters, expected.x, rtol=0.0, atol=1e-5)
    assert found.residual <= 1e-12


def test_a_batch_is_solved_one_by_one():
    random = np.random.default_rng(7)
    matrices = jnp.asarray(np.stack([positive(random) for _ in range(5)]))
    centres = jnp.asarray(random.normal(size=(5, 4)))
    starts = jnp.zeros((5, 4))
    together = jax.jit(jax.vmap(quadratic))(matrices, centres, starts)
    alone = [quadratic(*each).parameters for each in zip(matrices, centres, starts, strict=True)]
    assert np.allclose(together.parameters, np.stack(alone), rtol=0.0, atol=1e-13)
    assert {bool(active) for active in together.active} == {True, False}
