import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.hypergradients.linear_solve import BallConstraint, LinearSolution, conjugate_gradients, solve_dense

SIZE = 5


@jax.jit
def dense(matrix: jax.Array, wanted: jax.Array, constraint: BallConstraint) -> LinearSolution:
    return solve_dense(matrix, wanted, constraint)


@jax.jit
def iterated(matrix: jax.Array, wanted: jax.Array, constraint: BallConstraint) -> LinearSolution:
    return conjugate_gradients(lambda vector: matrix @ vector, wanted, constraint, 1e-13, 4 * SIZE)


def inside() -> BallConstraint:
    return BallConstraint.at(jnp.full(SIZE, 0.1), jnp.ones(SIZE))


def on_sphere(random: np.random.Generator, multiplier: float) -> BallConstraint:
    point = random.normal(size=SIZE)
    point = jnp.asarray(point / np.linalg.norm(point))
    return BallConstraint.at(point, -multiplier * point)


def expected(matrix: np.ndarray, wanted: np.ndarray, constraint: BallConstraint) -> np.ndarray:
    """P (P (H + νI) P)⁺ P b, by the pseudoinverse."""
    if not constraint.active:
        return np.linalg.solve(matrix, wanted)
    normal = np.asarray(constraint.normal)
    projection = np.eye(SIZE) - np.outer(normal, normal)
    tangential = projection @ (matrix + float(constraint.multiplier) * np.eye(SIZE)) @ projection
    return np.linalg.pinv(tangential, rcond=1e-12) @ projection @ wanted


def positive(random: np.random.Generator) -> np.ndarray:
    factor = random.normal(size=(SIZE, SIZE))
    return factor @ factor.T + 0.2 * np.eye(SIZE)


def close(found: jax.Array, wanted: np.ndarray, tolerance: float = 1e-9) -> bool:
    return float(np.linalg.norm(np.asarray(found) - wanted)) <= tolerance * float(np.linalg.norm(wanted))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("sphere", [False, True])
def test_elimination_and_conjugate_gradients_agree_with_numpy(seed, sphere):
    random = np.random.default_rng(seed)
    matrix, wanted = positive(random), random.normal(size=SIZE)
    constraint = on_sphere(random, 0.7) if sphere else inside()
    assert bool(constraint.active) == sphere
    truth = expected(matrix, wanted, constraint)
    for solve in (dense, iterated):
        found = solve(jnp.asarray(matrix), jnp.asarray(wanted), constraint)
        assert close(found.solution, truth)
        assert found.residual <= 1e-10
        assert abs(float(jnp.vdot(constraint.normal, found.solution))) <= 1e-12 or not sphere


@pytest.mark.parametrize("sphere", [False, True])
def test_elimination_takes_a_matrix_that_is_not_symmetric(sphere):
    random = np.random.default_rng(3)
    matrix, wanted = random.normal(size=(SIZE, SIZE)), random.normal(size=SIZE)
    constraint = on_sphere(random, 0.7) if sphere else inside()
    found = dense(jnp.asarray(matrix), jnp.asarray(wanted), constraint)
    assert close(found.solution, expected(matrix, wanted, constraint))


@pytest.mark.parametrize("seed", range(4))
def test_the_smallest_eigenvalue_is_that_of_the_symmetric_part(seed):
    random = np.random.default_rng(seed)
    matrix, wanted = random.normal(size=(SIZE, SIZE)), jnp.asarray(random.normal(size=SIZE))
    found = dense(jnp.asarray(matrix), wanted, inside())
    assert found.smallest_eigenvalue == pytest.approx(np.linalg.eigvalsh(0.5 * (matrix + matrix.T))[0], abs=1e-12)
    constraint = on_sphere(random, 0.7)
    # A basis of the tangent space: the normal's own direction does not count.
    basis = np.linalg.svd(np.asarray(constraint.normal)[None, :])[2][1:]
    tangential = basis @ (0.5 * (matrix + matrix.T) + 0.7 * np.eye(SIZE)) @ basis.T
    found = dense(jnp.asarray(matrix), wanted, constraint)
    assert found.smallest_eigenvalue == pytest.approx(np.linalg.eigvalsh(tangential)[0], abs=1e-12)


def test_conjugate_gradients_meet_an_upper_bound_of_the_smallest_eigenvalue():
    random = np.random.default_rng(0)
    matrix = positive(random)
    found = iterated(jnp.asarray(matrix), jnp.asarray(random.normal(size=SIZE)), inside())
    values = np.linalg.eigvalsh(matrix)
    assert values[0] - 1e-12 <= float(found.smallest_eigenvalue) <= values[-1]
    assert SIZE <= int(found.products) <= SIZE + 2


def test_a_matrix_that_the_multiplier_makes_positive_is_solved_on_the_sphere():
    random = np.random.default_rng(1)
    matrix, wanted = positive(random) - 0.9 * np.eye(SIZE), random.normal(size=SIZE)
    assert np.linalg.eigvalsh(matrix)[0] < 0.0
    constraint = on_sphere(random, 1.0)
    for solve in (dense, iterated):
        found = solve(jnp.asarray(matrix), jnp.asarray(wanted), constraint)
        assert close(found.solution, expected(matrix, wanted, constraint))
        assert found.smallest_eigenvalue > 0.0


def test_a_matrix_singular_along_the_normal_alone_is_solved_on_the_sphere():
    random = np.random.default_rng(2)
    constraint = on_sphere(random, 0.0 + 1e-300)
    projection = np.eye(SIZE) - np.outer(constraint.normal, constraint.normal)
    matrix, wanted = projection @ positive(random) @ projection, random.normal(size=SIZE)
    for solve in (dense, iterated):
        found = solve(jnp.asarray(matrix), jnp.asarray(wanted), constraint)
        assert close(found.solution, expected(matrix, wanted, constraint))


def test_conjugate_gradients_solve_a_singular_system_that_has_a_solution():
    random = np.random.default_rng(4)
    values = np.array([0.0, 0.0, 1.0, 2.0, 3.0])
    vectors = np.linalg.qr(random.normal(size=(SIZE, SIZE)))[0]
    matrix = (vectors * values) @ vectors.T
    wanted = matrix @ random.normal(size=SIZE)
    found = iterated(jnp.asarray(matrix), jnp.asarray(wanted), inside())
    assert close(found.solution, np.linalg.pinv(matrix, rcond=1e-10) @ wanted)


def test_conjugate_gradients_stop_where_the_curvature_is_not_positive():
    matrix = jnp.diag(jnp.asarray([1.0, 2.0, -3.0, 4.0, 5.0]))
    stopped = iterated(matrix, jnp.ones(SIZE), inside())
    assert stopped.smallest_eigenvalue <= 0.0
    assert stopped.products < SIZE
    assert stopped.residual > 0.01
    assert np.all(np.isfinite(stopped.solution))
    # Already the first direction: nothing is moved.
    first = iterated(-jnp.eye(SIZE), jnp.ones(SIZE), inside())
    assert (int(first.products), float(first.smallest_eigenvalue), float(first.residual)) == (1, -1.0, 1.0)
    assert np.array_equal(first.solution, np.zeros(SIZE))


def test_conjugate_gradients_say_so_when_they_run_out_of_iterations():
    random = np.random.default_rng(5)
    matrix, wanted = jnp.asarray(positive(random)), jnp.asarray(random.normal(size=SIZE))
    found = conjugate_gradients(lambda vector: matrix @ vector, wanted, inside(), 1e-13, 2)
    assert int(found.products) == 2
    assert found.residual == pytest.approx(
        float(jnp.linalg.norm(matrix @ found.solution - wanted) / jnp.linalg.norm(wanted)), rel=1e-9
    )
    assert found.residual > 1e-3


@pytest.mark.parametrize("solve", [dense, iterated])
def test_nothing_wanted_is_nothing_found(solve):
    found = solve(jnp.eye(SIZE), jnp.zeros(SIZE), inside())
    assert np.array_equal(found.solution, np.zeros(SIZE))
    assert found.residual == 0.0


@pytest.mark.parametrize(
    ("norm", "outwards", "active"),
    [(1.0, 1.0, True), (1.0 - 1e-12, 1.0, True), (0.999, 1.0, False), (1.0, -1.0, False), (0.0, 1.0, False)],
)
def test_the_ball_is_active_on_the_sphere_where_descent_points_outwards(norm, outwards, active):
    direction = jnp.asarray([0.6, 0.0, 0.8])
    constraint = BallConstraint.at(norm * direction, -0.5 * outwards * direction)
    assert bool(constraint.active) == active
    assert constraint.multiplier == pytest.approx(0.5 * norm if active else 0.0, abs=1e-15)
    vector = jnp.asarray([1.0, 2.0, 3.0])
    projected = vector - 3.0 * direction if active else vector
    assert np.allclose(constraint.project(vector), projected, rtol=0.0, atol=1e-9)
