import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.hypergradients.implicit import Implicit
from gsiirl.theory.checks import theorem_2
from gsiirl.theory.checks.theorem_2 import Iteration
from gsiirl.theory.support.slopes import fitted_slope

REGULARISATION = 0.05


@pytest.fixture(scope="module")
def games():
    return theorem_2.draw_games(number=2, points=2)


@pytest.fixture(scope="module")
def iteration(games):
    *_, last = theorem_2.algorithm_1(games, 1.0 / games.upper_smoothness, 3, REGULARISATION)
    return last


def test_the_total_derivative_is_that_of_f_at_the_moving_minimiser(games):
    def objective(commitments):
        played = theorem_2.equilibria(games.problems, commitments, games.estimates)
        minimiser = theorem_2.minimisers(games.problems, played.learner_policy, REGULARISATION)
        return np.asarray(theorem_2.equilibria(games.problems, commitments, minimiser).objective)

    played = theorem_2.equilibria(games.problems, games.commitments, games.estimates)
    value, found = theorem_2.total_derivatives(games, games.commitments, played, REGULARISATION)
    np.testing.assert_allclose(value, objective(games.commitments), rtol=1e-12)
    step = 1e-4
    expected = np.stack(
        [
            (objective(games.commitments + shift[None, :]) - objective(games.commitments - shift[None, :])) / (2 * step)
            for shift in step * jnp.eye(found.shape[1])
        ],
        axis=1,
    )
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())
    # The response is a part of it that this comparison would miss at once.
    alone = theorem_2.equilibria(
        games.problems,
        games.commitments,
        theorem_2.minimisers(games.problems, played.learner_policy, REGULARISATION),
    )
    assert np.abs(np.asarray(alone.through_learner) - expected).max() > 1e-3 * np.abs(expected).max()


@pytest.mark.slow
def test_derivatives_are_those_of_the_implicit_estimator(games, iteration: Iteration):
    """`measured` with the demonstrations' Jacobian by differences is ours; with a Jacobian of 0 it is `frozen`."""
    problem = jax.tree.map(lambda leaf: leaf[1], games.problems)
    believed, commitment, step = games.estimates[1], iteration.commitments[1], 1e-5

    @jax.jit
    def estimate(expert_parameters, demonstrated, moved):
        lower = problem.bilevel(REGULARISATION).problem(believed, demonstrated, moved)
        found, _ = Implicit("measured").estimate(
            lower, commitment, expert_parameters, None, jax.random.key(0), jnp.asarray(0)
        )
        return found.value

    def demonstrated(shift):
        played = theorem_2.equilibria(games.problems, iteration.commitments + shift[None, :], games.estimates)
        return played, theorem_2.demonstrations(games.problems, played.learner_policy)

    shifts = step * jnp.eye(commitment.shape[0])
    moved = jnp.stack([(demonstrated(each)[1] - demonstrated(-each)[1])[1] / (2 * step) for each in shifts], axis=1)
    played, here = demonstrated(0.0 * commitment)
    minimisers = theorem_2.minimisers(games.problems, played.learner_policy, REGULARISATION)
    _, total = theorem_2.total_derivatives(games, iteration.commitments, played, REGULARISATION)
    np.testing.assert_allclose(total[1], estimate(minimisers[1], here[1], moved), rtol=0, atol=1e-7)
    held = Iteration(0, iteration.commitments, played, here, iteration.estimates)
    printed = theorem_2.frozen(games, held, REGULARISATION)[1]
    np.testing.assert_allclose(printed, estimate(iteration.estimates[1], here[1], 0.0 * moved), rtol=1e-9, atol=1e-12)
    assert float(jnp.linalg.norm(total[1] - printed)) > 1e-3


def test_the_gradient_mapping_is_the_gradient_inside_the_ball():
    gradient, step = jnp.array([0.3, -2.0, 0.5]), jnp.asarray(0.1)
    found = theorem_2.gradient_mapping(jnp.array([0.1, 0.2, -0.3]), gradient, step)
    np.testing.assert_allclose(found, gradient, rtol=1e-13)


def test_the_gradient_mapping_vanishes_at_a_constrained_maximiser_and_only_there():
    point, step = jnp.array([0.6, 0.0, -0.8]), jnp.asarray(1e-6)
    np.testing.assert_allclose(theorem_2.gradient_mapping(point, 3.0 * point, step), 0.0, atol=1e-9)
    tangent = jnp.array([0.8, 1.0, 0.6])
    np.testing.assert_allclose(
        theorem_2.gradient_mapping(point, 3.0 * point + tangent, step), tangent, rtol=0, atol=1e-4
    )
    # A gradient that points inwards moves the point: it is no maximiser.
    inwards = -3.0 * point
    np.testing.assert_allclose(theorem_2.gradient_mapping(point, inwards, step), inwards, rtol=1e-9)


def test_inner_steps_follow_the_papers_formula():
    found = np.array([int(theorem_2.inner_steps(jnp.asarray(k))) for k in range(0, 1600, 3)])
    np.testing.assert_array_equal(found, np.ceil((np.arange(0, 1600, 3) + 1.0) ** 0.25 / 2.0 - 1e-12))
    edges = [int(theorem_2.inner_steps(jnp.asarray(k))) for k in (0, 15, 16, 255, 256, 1295, 1296)]
    assert edges == [1, 1, 2, 2, 3, 3, 4]


def test_an_iteration_takes_its_inner_steps_from_where_the_last_one_ended(games):
    iterations = list(theorem_2.algorithm_1(games, 1.0 / games.upper_smoothness, 18, REGULARISATION))
    rates = np.asarray(1.0 / (games.lower_smoothness + REGULARISATION))
    for before, now in ((iterations[2], iterations[3]), (iterations[16], iterations[17])):
        estimates = before.estimates
        for _ in range(1 if now.number < 16 else 2):
            slopes = theorem_2.lower_gradients(
                games.problems, now.played.learner_policy, now.demonstrated, estimates, REGULARISATION
            )
            estimates = jax.vmap(theorem_2.project)(estimates - rates[:, None] * slopes)
        np.testing.assert_allclose(now.estimates, estimates, rtol=1e-12)
        assert np.abs(np.asarray(now.estimates - before.estimates)).max() > 1e-6
        direction = theorem_2.well_specified(games, before, REGULARISATION)
        assert np.all(np.linalg.norm(now.commitments, axis=1) <= 1.0 + 1e-12)
        if now.number == before.number + 1:
            moved = jax.vmap(theorem_2.project)(before.commitments + direction / games.upper_smoothness[:, None])
            np.testing.assert_allclose(now.commitments, moved, rtol=1e-12)


def test_inner_steps_end_at_the_minimiser(games, iteration: Iteration):
    rates = 1.0 / (games.lower_smoothness + REGULARISATION)
    found = theorem_2.fits(
        games.problems,
        iteration.played.learner_policy,
        iteration.demonstrated,
        games.estimates,
        REGULARISATION,
        rates,
        jnp.asarray(3000),
    )
    expected = theorem_2.minimisers(games.problems, iteration.played.learner_policy, REGULARISATION)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_one_draw_of_spsa_is_the_gradient_along_its_direction(games, iteration: Iteration):
    gradient = np.asarray(theorem_2.well_specified(games, iteration, REGULARISATION))
    found = np.asarray(theorem_2.simultaneous_perturbation(1e-4, 0.0)(games, iteration, REGULARISATION))
    # (g·Δ) Δ with Δ of signs: all entries alike in size, and along their own signs the gradient gives that size.
    np.testing.assert_allclose(np.abs(found), np.abs(found[:, :1]) * np.ones(found.shape), rtol=1e-12)
    np.testing.assert_allclose(np.sum(gradient * np.sign(found), axis=1), np.abs(found[:, 0]), rtol=1e-5)


def test_sampled_demonstrations_scatter_around_the_exact_ones(games, iteration: Iteration):
    draws = np.stack(
        [np.asarray(theorem_2.demonstrated_by_samples(games, number, iteration.played)) for number in range(60)]
    )
    exact = np.asarray(theorem_2.demonstrated_exactly(games, 0, iteration.played))
    error = draws.std(axis=0) / np.sqrt(len(draws))
    assert np.all(error > 0)
    assert np.all(np.abs(draws.mean(axis=0) - exact) <= 4.5 * error)


def test_averages_are_of_the_first_iterations():
    squared = np.arange(12.0).reshape(6, 2)
    measured = theorem_2.Measured(squared, squared, np.zeros((6, 2, 3)))
    np.testing.assert_array_equal(measured.averages([1, 3]), [[0.0, 1.0], [2.0, 3.0]])


def test_the_slope_is_that_of_a_power_law():
    ks = [25, 50, 100, 400]
    assert fitted_slope(ks, [3.0 * k**-0.7 for k in ks]) == pytest.approx(-0.7, abs=1e-12)
    # Not a power law: least squares over the logarithms, here by hand for three points.
    assert fitted_slope([1, np.e, np.e**2], [1.0, np.e, np.e]) == pytest.approx(0.5, abs=1e-12)


@pytest.mark.slow
def test_the_quick_check_holds():
    assert theorem_2.check(quick=True).holds
