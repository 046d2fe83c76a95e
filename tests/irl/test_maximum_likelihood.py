import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest

from gsiirl.equilibria import Logit, respond
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.irl import MaximumLikelihood, Memory, Played, reward_gradient_expectation
from gsiirl.irl.maximum_likelihood import constant_steps, growing_steps
from gsiirl.learners.bilevel import Bilevel
from gsiirl.rewards import Linear
from gsiirl.rewards import attack_graph as rewards
from gsiirl.types import Sides
from tests import helpers, oracles

TEMPERATURE, DISCOUNT, INTERACTIONS, STEPS = 0.4, 0.95, 4, 3


class Problem(eqx.Module):
    """Exact demonstrations of a known expert under several policies of the learner, on the small attack graph."""

    game: AttackGraph
    reward: Linear
    true: jax.Array
    memory: Memory
    level: MaximumLikelihood


@pytest.fixture(scope="module")
def problem() -> Problem:
    network = helpers.small_network()
    game = AttackGraph.create(network, 6)
    weights = jnp.asarray(rewards.expert_weights(network))
    scale = 2.0 * float(jnp.linalg.norm(weights))
    reward, true = Linear(rewards.attack_features(game), scale), weights / scale
    edges = game.number_of_edges
    played = jnp.stack(
        [jnp.asarray(oracles.random_policy(k, 6, game.number_of_states, edges)) for k in range(INTERACTIONS)]
    )

    def demonstrated(learner_policy):
        expert = respond(game, learner_policy, reward.payoff(true), TEMPERATURE, DISCOUNT).policy
        return reward_gradient_expectation(game, reward, Sides(learner_policy, expert), DISCOUNT)

    # One slot more than interactions: what was never filled must not count.
    memory = Memory.empty(INTERACTIONS + 1, Played(jnp.zeros_like(played[0]), jnp.zeros_like(true)))
    for index, (policy, seen) in enumerate(zip(played, jax.jit(jax.vmap(demonstrated))(played), strict=True)):
        memory = memory.remember(jax.random.key(index), Played(policy, seen))
    level = MaximumLikelihood(TEMPERATURE, constant_steps(STEPS), optax.sgd(0.05))
    return Problem(game, reward, true, memory, level)


def averaged_gradient(problem: Problem, theta: jax.Array) -> jax.Array:
    """∇L over the memory, without regularisation; only the expert's side of the two levels matters here."""
    dependent = rewards.commitment_features(problem.game)
    nothing = dependent.payoff(jnp.zeros(len(dependent.names)))
    level = Bilevel(
        game=problem.game,
        own_reward=nothing,
        accessed=nothing,
        dependent_reward=Linear(dependent, 1.0),
        expert_reward=problem.reward,
        forward_model=Logit(TEMPERATURE),
        temperature=TEMPERATURE,
        discount=DISCOUNT,
        regularisation=0.0,
    )
    return level.lower_gradient(jnp.zeros(len(dependent.names)), theta, problem.memory)


@eqx.filter_jit
def gradient(problem: Problem, theta: jax.Array) -> jax.Array:
    return averaged_gradient(problem, theta)


@eqx.filter_jit
def hessian(problem: Problem, theta: jax.Array) -> jax.Array:
    return jax.jacfwd(lambda x: averaged_gradient(problem, x))(theta)


@eqx.filter_jit
def fit(problem: Problem, theta: jax.Array) -> jax.Array:
    state = problem.level.optimiser.init(theta)
    return problem.level.fit(lambda x: averaged_gradient(problem, x), theta, state, jnp.asarray(0))[0]


def test_the_truth_is_a_fixed_point(problem):
    assert float(jnp.max(jnp.abs(gradient(problem, problem.true)))) <= 1e-12
    np.testing.assert_allclose(fit(problem, problem.true), problem.true, atol=1e-12)


def test_exact_demonstrations_recover_the_truth_in_every_identified_direction(problem):
    assert float(jnp.linalg.norm(problem.true)) < 1.0
    theta = jnp.zeros_like(problem.true)
    # Damped Newton within what the data say; the objective is convex.
    for _ in range(30):
        slope, curvature = np.asarray(gradient(problem, theta)), np.asarray(hessian(problem, theta))
        step = np.linalg.lstsq(curvature, -slope, rcond=1e-9)[0]
        theta = theta + jnp.asarray(step * min(1.0, 0.2 / np.linalg.norm(step)))
    assert float(jnp.max(jnp.abs(gradient(problem, theta)))) <= 1e-11
    eigenvalues, directions = np.linalg.eigh(np.asarray(hessian(problem, problem.true)))
    identified = eigenvalues >= 1e-3 * eigenvalues[-1]
    # At least the values of the nodes that can be taken are among them.
    assert identified.sum() >= 3
    np.testing.assert_allclose(directions[:, identified].T @ np.asarray(theta - problem.true), 0.0, atol=1e-6)


def test_the_hessian_is_symmetric_and_positive_semidefinite(problem):
    for seed in range(3):
        curvature = np.asarray(hessian(problem, jax.random.ball(jax.random.key(seed), problem.true.shape[0])))
        largest = np.abs(curvature).max()
        np.testing.assert_allclose(curvature, curvature.T, atol=1e-12 * largest)
        assert np.linalg.eigvalsh(curvature).min() >= -1e-12 * largest


def test_the_gradient_is_monotone(problem):
    points = jax.random.ball(jax.random.key(7), problem.true.shape[0], shape=(8,))
    slopes = [gradient(problem, point) for point in points]
    for one in range(8):
        for other in range(one):
            assert float(jnp.vdot(points[one] - points[other], slopes[one] - slopes[other])) >= 0.0


def test_steps_stay_in_the_unit_ball_and_the_projection_binds_where_it_should(problem):
    # With a scale twice too small the truth lies outside, and the boundary is where the steps end.
    tight = eqx.tree_at(lambda p: p.reward, problem, Linear(problem.reward.features, 0.2))
    tight = eqx.tree_at(
        lambda p: p.memory.kept.demonstrated, tight, 0.2 / problem.reward.scale * problem.memory.kept.demonstrated
    )
    tight = eqx.tree_at(lambda p: p.level, tight, MaximumLikelihood(TEMPERATURE, constant_steps(40), optax.sgd(5.0)))
    theta = fit(tight, jnp.zeros_like(problem.true))
    assert float(jnp.linalg.norm(theta)) == pytest.approx(1.0, abs=1e-12)


def test_a_step_of_plain_descent_is_that_of_the_temperature_times_the_gradient(problem):
    theta = 0.3 * jax.random.ball(jax.random.key(2), problem.true.shape[0])
    expected = theta
    for _ in range(STEPS):
        expected = expected - 0.05 * TEMPERATURE * gradient(problem, expected)
    np.testing.assert_allclose(fit(problem, theta), expected, atol=1e-14)


def test_growing_steps_are_the_papers_formula():
    iterations = np.concatenate([np.arange(300), np.arange(1290, 1300), [4094, 4095, 4096, 9999]])
    expected = np.ceil((iterations + 1.0) ** 0.25 / 2)
    # Where (k+1)^(1/4)/2 is whole, rounding must not add a step.
    for k, steps in ((15, 1), (16, 2), (255, 2), (256, 3), (1295, 3), (1296, 4)):
        expected[iterations == k] = steps
    np.testing.assert_array_equal(jax.jit(jax.vmap(growing_steps))(jnp.asarray(iterations)), expected)


def test_as_many_steps_are_taken_as_the_iteration_asks_for():
    counting = MaximumLikelihood(1.0, growing_steps, optax.sgd(1e-3))
    moved = [
        float(
            jax.jit(lambda k: counting.fit(jnp.ones_like, jnp.zeros(1), counting.optimiser.init(jnp.zeros(1)), k)[0])(
                jnp.asarray(k)
            )[0]
        )
        for k in (0, 16, 256)
    ]
    np.testing.assert_allclose(moved, [-0.001, -0.002, -0.003], atol=1e-15)


def test_the_first_iteration_may_take_more_steps():
    steps = constant_steps(3, first=7)
    assert [int(steps(jnp.asarray(iteration))) for iteration in range(3)] == [7, 3, 3]
    assert constant_steps(3)(jnp.asarray(0)) == 3


def test_on_the_sphere_a_short_vector_is_made_as_long_as_a_long_one():
    level = MaximumLikelihood(1.0, constant_steps(1), optax.sgd(1.0), on_sphere=True)
    for start in ([0.01, 0.0], [3.0, 0.0]):
        theta = jnp.asarray(start)
        gradient = -jnp.asarray([0.0, 4.0 / 3.0]) * jnp.linalg.norm(theta)
        stepped, _ = level.step(gradient, theta, level.optimiser.init(theta))
        np.testing.assert_allclose(stepped, [0.6, 0.8], rtol=1e-12)


def test_on_the_sphere_what_changes_the_length_alone_moves_nothing():
    # Clipping entry by entry, like Adam, turns the step of a gradient with a long part along θ.
    level = MaximumLikelihood(1.0, constant_steps(1), optax.chain(optax.clip(1.0), optax.sgd(0.1)), on_sphere=True)
    at, across = jnp.asarray([0.6, 0.8, 0.0]), jnp.asarray([0.8, -0.6, 1.0])
    start = level.optimiser.init(at)
    plain, _ = level.step(across, at, start)
    longer, _ = level.step(across + 30.0 * at, at, start)
    np.testing.assert_allclose(longer, plain, atol=1e-6)
    assert float(jnp.linalg.norm(plain - at)) > 0.01
