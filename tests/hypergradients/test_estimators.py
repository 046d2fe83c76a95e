from collections import Counter
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.hypergradients import (
    SPSA,
    AbstractEstimator,
    BilevelProblem,
    FiniteDifference,
    HessianVectorCG,
    Hypergradient,
    Implicit,
    ResponseKind,
)
from gsiirl.hypergradients.spsa import Factors
from gsiirl.theory.support.direct import Direct
from gsiirl.theory.support.games import RandomProblem, Size
from gsiirl.theory.support.lower_solution import solve_lower
from gsiirl.theory.support.soft_joint_model import SoftJointModel

LEARNER_SIZE, EXPERT_SIZE, REGULARISATION = 4, 3, 0.2
KEY = jax.random.key(0)
RESPONSES: tuple[ResponseKind, ...] = ("well_specified", "frozen", "measured")
EXACT: tuple[Callable[[ResponseKind], AbstractEstimator], ...] = (Implicit, HessianVectorCG, FiniteDifference)


class Quadratic(eqx.Module):
    """f = a·l + b·e + lᵀC e and L = eᵀA e/2 + eᵀ(M l − c) + λ‖e‖²/2, with dD/dl = J."""

    learner_slope: jax.Array
    expert_slope: jax.Array
    cross: jax.Array
    hessian: jax.Array
    mixed: jax.Array
    moving: jax.Array
    offset: jax.Array

    def objective(self, learner: jax.Array, expert: jax.Array) -> jax.Array:
        return self.learner_slope @ learner + self.expert_slope @ expert + learner @ self.cross @ expert

    def problem(self, met: Counter[str] | None = None) -> BilevelProblem:
        """The problem; every call of `evaluate` and `upper_gradient` is added to `met`, also of a batch."""

        def count(name: str, learner: jax.Array, expert: jax.Array) -> None:
            counter = met
            if counter is not None:
                # The point is an argument so that a batch is counted one by one.
                jax.debug.callback(lambda *_: counter.update([name]), learner, expert)

        def evaluate(learner: jax.Array, expert: jax.Array) -> tuple[jax.Array, jax.Array]:
            count("evaluations", learner, expert)
            return self.objective(learner, expert), self.hessian @ expert + self.mixed @ learner - self.offset

        def upper_gradient(learner: jax.Array, expert: jax.Array) -> jax.Array:
            count("upper_evaluations", learner, expert)
            return self.mixed.T @ expert

        return BilevelProblem(evaluate, REGULARISATION, upper_gradient, self.moving)


def quadratic(seed: int, on_sphere: bool, curvature: float = 0.5) -> tuple[Quadratic, jax.Array, jax.Array]:
    """A problem with a point θ_l and the θ_e* there, inside the ball or on its sphere."""
    random = np.random.default_rng(seed)
    factor = random.normal(size=(EXPERT_SIZE, EXPERT_SIZE))
    hessian = factor @ factor.T + curvature * np.eye(EXPERT_SIZE)
    expert = random.normal(size=EXPERT_SIZE)
    expert /= np.linalg.norm(expert) * (1.0 if on_sphere else 2.0)
    learner, mixed = random.normal(size=LEARNER_SIZE), random.normal(size=(EXPERT_SIZE, LEARNER_SIZE))
    # G = 0 inside; on the sphere G = −ν e with ν = 0.8.
    multiplier = 0.8 if on_sphere else 0.0
    offset = (hessian + (REGULARISATION + multiplier) * np.eye(EXPERT_SIZE)) @ expert + mixed @ learner
    problem = Quadratic(
        learner_slope=jnp.asarray(random.normal(size=LEARNER_SIZE)),
        expert_slope=jnp.asarray(random.normal(size=EXPERT_SIZE)),
        cross=jnp.asarray(random.normal(size=(LEARNER_SIZE, EXPERT_SIZE))),
        hessian=jnp.asarray(hessian),
        mixed=jnp.asarray(mixed),
        moving=jnp.asarray(random.normal(size=(EXPERT_SIZE, LEARNER_SIZE))),
        offset=jnp.asarray(offset),
    )
    return problem, jnp.asarray(learner), jnp.asarray(expert)


def closed_form(problem: Quadratic, learner: jax.Array, expert: jax.Array, response: ResponseKind) -> np.ndarray:
    """∇f from the conditions of Karush, Kuhn and Tucker: [[H + νI, e], [eᵀ, 0]] [de; dν] = [−M dl; 0]."""
    through_learner = np.asarray(problem.learner_slope + problem.cross @ expert)
    if response == "well_specified":
        return through_learner
    mixed = np.asarray(problem.mixed - problem.moving if response == "measured" else problem.mixed)
    hessian = np.asarray(problem.hessian) + REGULARISATION * np.eye(EXPERT_SIZE)
    gradient = np.asarray(problem.hessian @ expert + problem.mixed @ learner - problem.offset + REGULARISATION * expert)
    if float(np.linalg.norm(expert)) < 0.99:
        moves = -np.linalg.solve(hessian, mixed)
    else:
        bordered = np.zeros((EXPERT_SIZE + 1, EXPERT_SIZE + 1))
        bordered[:-1, :-1] = hessian - float(expert @ gradient) * np.eye(EXPERT_SIZE)
        bordered[:-1, -1] = bordered[-1, :-1] = np.asarray(expert)
        moves = np.linalg.solve(bordered, np.vstack([-mixed, np.zeros((1, LEARNER_SIZE))]))[:-1]
    return through_learner + moves.T @ np.asarray(problem.expert_slope + problem.cross.T @ learner)


@eqx.filter_jit
def jitted(
    estimator: AbstractEstimator, problem: Quadratic, learner: jax.Array, expert: jax.Array, key: jax.Array
) -> Hypergradient:
    """The first estimate."""
    return estimator.estimate(
        problem.problem(), learner, expert, estimator.init(expert), key, jnp.zeros((), jnp.int32)
    )[0]


def estimate(
    estimator: AbstractEstimator, problem: BilevelProblem, learner: jax.Array, expert: jax.Array
) -> Hypergradient:
    """The first estimate of a problem given as callables."""

    @jax.jit
    def first(learner: jax.Array, expert: jax.Array) -> Hypergradient:
        start = jnp.zeros((), jnp.int32)
        return estimator.estimate(problem, learner, expert, estimator.init(expert), KEY, start)[0]

    return first(learner, expert)


def relative(found: jax.Array, truth: np.ndarray) -> float:
    return float(np.linalg.norm(np.asarray(found) - truth) / np.linalg.norm(truth))


# --- exact estimators ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("response", RESPONSES)
@pytest.mark.parametrize("make", EXACT)
def test_exact_estimators_give_the_closed_form_jitted_and_for_a_batch(make, response):
    # Games inside the ball and on its sphere in one batch: what is done must not depend on the others.
    cases = [quadratic(seed, on_sphere) for seed in range(3) for on_sphere in (False, True)]
    stacked = jax.tree.map(lambda *leaves: jnp.stack(leaves), *cases)
    keys = jax.random.split(KEY, len(cases))
    together = eqx.filter_vmap(jitted, in_axes=(None, 0, 0, 0, 0))(make(response), *stacked, keys)
    for number, case in enumerate(cases):
        truth = closed_form(*case, response)
        assert relative(together.value[number], truth) <= 1e-8
        assert bool(together.constrained[number]) == (number % 2 == 1 and response != "well_specified")
    assert np.allclose(together.value, together.through_learner + together.through_expert, rtol=0.0, atol=1e-12)
    alone = jitted(make(response), *cases[1], keys[1])
    assert np.allclose(alone.value, together.value[1], rtol=0.0, atol=1e-10)


def test_a_response_matters():
    case = quadratic(0, False)
    found = [closed_form(*case, response) for response in RESPONSES]
    assert min(relative(jnp.asarray(one), other) for one in found for other in found if one is not other) > 0.1


@pytest.fixture(scope="module")
def game() -> tuple[SoftJointModel, jax.Array, jax.Array]:
    """A random game under the joint softmax, where all estimators apply, with θ_e* inside the ball."""
    size = Size(states=3, learner_actions=2, expert_actions=2, horizon=3)
    model = SoftJointModel(RandomProblem.draw(1, size), REGULARISATION)
    learner = jnp.asarray([0.3, -0.5, 0.2, 0.4])
    solve = eqx.filter_jit(
        lambda model: solve_lower(
            lambda theta: model.problem(learner, theta).lower_gradient(learner, theta), model.instance.true_parameters
        )
    )
    return model, learner, solve(model).parameters


def test_exact_estimators_agree_on_a_game(game):
    model, learner, expert = game
    assert float(jnp.linalg.norm(expert)) < 1.0

    @eqx.filter_jit
    def every(model: SoftJointModel) -> list[Hypergradient]:
        problem = model.problem(learner, expert)
        return [estimate(make("measured"), problem, learner, expert) for make in (*EXACT, Direct)]

    implicit, *others = every(model)
    assert float(jnp.linalg.norm(implicit.through_expert)) > 1e-3 * float(jnp.linalg.norm(implicit.value))
    for other in others:
        assert relative(other.value, np.asarray(implicit.value)) <= 1e-6
        assert relative(other.through_learner, np.asarray(implicit.through_learner)) <= 1e-6


def test_what_measured_and_conjugate_gradients_need_is_asked_for():
    problem, learner, expert = quadratic(0, False)
    whole = problem.problem()
    unmeasured = BilevelProblem(whole.evaluate, REGULARISATION, whole.upper_gradient)
    for make in (*EXACT, SPSA):
        with pytest.raises(ValueError, match="demonstration_jacobian"):
            estimate(make("measured"), unmeasured, learner, expert)
    no_likelihood = BilevelProblem(whole.evaluate, REGULARISATION, None, whole.demonstration_jacobian)
    for response in ("frozen", "measured"):
        with pytest.raises(ValueError, match="upper_gradient"):
            estimate(HessianVectorCG(response), no_likelihood, learner, expert)
        with pytest.raises(ValueError, match="LemmaThreeProblem"):
            estimate(Direct(response), whole, learner, expert)


# --- diagnostics -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("estimator", "passes"),
    [
        # The columns of H, ∇f, and the product with M.
        (Implicit("frozen"), EXPERT_SIZE + 2),
        (HessianVectorCG("frozen"), 1),
        (FiniteDifference("frozen"), 0),
        (SPSA("frozen", draws=3), 0),
        (Implicit("well_specified"), 1),
        (FiniteDifference("well_specified"), 0),
        (SPSA("well_specified", draws=3), 0),
    ],
)
def test_calls_are_counted_as_they_are_made(estimator, passes):
    problem, learner, expert = quadratic(0, False)
    met: Counter[str] = Counter()
    found = estimate(estimator, problem.problem(met), learner, expert)
    jax.block_until_ready(found)
    jax.effects_barrier()
    assert int(found.evaluations) == met["evaluations"]
    assert int(found.upper_evaluations) == met["upper_evaluations"]
    assert int(found.calls) == met.total() + passes
    assert met["evaluations"] > 0


@pytest.mark.parametrize("on_sphere", [False, True])
def test_residual_and_smallest_eigenvalue(on_sphere):
    problem, learner, expert = quadratic(1, on_sphere)
    hessian = np.asarray(problem.hessian) + REGULARISATION * np.eye(EXPERT_SIZE)
    normal = np.asarray(expert) / np.linalg.norm(expert)
    # On the sphere that of H + νI on the tangent space.
    basis = np.linalg.svd(normal[None, :])[2][1:] if on_sphere else np.eye(EXPERT_SIZE)
    truth = np.linalg.eigvalsh(basis @ (hessian + 0.8 * on_sphere * np.eye(EXPERT_SIZE)) @ basis.T)
    for make in (Implicit, FiniteDifference):
        found = jitted(make("frozen"), problem, learner, expert, KEY)
        assert found.smallest_eigenvalue == pytest.approx(truth[0], rel=1e-7)
        assert found.linear_residual <= 1e-13
    found = jitted(HessianVectorCG("frozen", tolerance=1e-10), problem, learner, expert, KEY)
    assert truth[0] * (1.0 - 1e-7) <= float(found.smallest_eigenvalue) <= truth[-1] * (1.0 + 1e-7)
    assert 0.0 < float(found.linear_residual) <= 1e-10
    rough = jitted(HessianVectorCG("frozen", iterations=1), problem, learner, expert, KEY)
    assert float(rough.linear_residual) > 1e-3
    nothing = jitted(Implicit("well_specified"), problem, learner, expert, KEY)
    assert (float(nothing.linear_residual), float(nothing.smallest_eigenvalue)) == (0.0, np.inf)


def test_negative_curvature_is_told():
    # A matrix with eigenvalues below −λ.
    problem, learner, expert = quadratic(2, False, curvature=-6.0)
    hessian = np.asarray(problem.hessian) + REGULARISATION * np.eye(EXPERT_SIZE)
    assert np.linalg.eigvalsh(hessian)[0] < 0.0
    exact = jitted(Implicit("frozen"), problem, learner, expert, KEY)
    assert exact.smallest_eigenvalue == pytest.approx(np.linalg.eigvalsh(hessian)[0], rel=1e-9)
    assert relative(exact.value, closed_form(problem, learner, expert, "frozen")) <= 1e-9
    stopped = jitted(HessianVectorCG("frozen"), problem, learner, expert, KEY)
    assert float(stopped.smallest_eigenvalue) <= 0.0
    assert float(stopped.linear_residual) > 1e-3
    assert np.all(np.isfinite(stopped.value))


# --- SPSA ------------------------------------------------------------------------------------------------------------


@eqx.filter_jit
def factors_of(
    spsa: SPSA, problem: Quadratic, learner: jax.Array, expert: jax.Array, key: jax.Array, reach: jax.Array
) -> Factors:
    """The factors of one draw after another at perturbation `reach`."""
    return spsa.factors(problem.problem(), learner, expert, key, reach)


@pytest.fixture
def every_direction(monkeypatch: pytest.MonkeyPatch) -> int:
    """Random signs come as all sign vectors in turn: the mean of so many draws is the expectation."""

    def rademacher(key: jax.Array, shape: tuple[int, int], dtype: jnp.dtype) -> jax.Array:
        numbers = np.arange(shape[0])[:, None] >> np.arange(shape[1])[None, :]
        return jnp.asarray(1.0 - 2.0 * (numbers & 1), dtype)

    monkeypatch.setattr(jax.random, "rademacher", rademacher)
    return 2**LEARNER_SIZE


@pytest.mark.parametrize("on_sphere", [False, True])
def test_spsa_is_unbiased_where_nothing_is_curved(every_direction, on_sphere):
    problem, learner, expert = quadratic(3, on_sphere)
    for response in RESPONSES:
        spsa = SPSA(response, perturbation=0.3, draws=every_direction)
        found = jitted(spsa, problem, learner, expert, KEY)
        assert relative(found.value, closed_form(problem, learner, expert, response)) <= 1e-8
        assert bool(found.constrained) == (on_sphere and response != "well_specified")
    factors = factors_of(SPSA("frozen", draws=every_direction), problem, learner, expert, KEY, jnp.asarray(0.3))
    for found, truth in (
        (factors.learner_gradient, problem.learner_slope + problem.cross @ expert),
        (factors.expert_gradient, problem.expert_slope + problem.cross.T @ learner),
        (factors.hessian, problem.hessian),
        (factors.mixed, problem.mixed),
    ):
        assert np.allclose(jnp.mean(found, axis=0), truth, rtol=0.0, atol=1e-12)
        # One draw alone is far off.
        assert not np.allclose(found[0], truth, rtol=0.1)


def test_spsa_averages_the_hessian_over_iterations():
    problem, learner, expert = quadratic(4, False)
    spsa = SPSA("frozen", draws=2)
    step = eqx.filter_jit(
        lambda state, key, iteration: spsa.estimate(problem.problem(), learner, expert, state, key, iteration)
    )
    state, drawn = spsa.init(expert), []
    for iteration in range(4):
        key = jax.random.key(iteration)
        found, state = step(state, key, jnp.asarray(iteration, jnp.int32))
        reach = jnp.asarray(spsa.perturbation / (iteration + 1.0) ** spsa.decay)
        drawn.extend(np.asarray(factors_of(spsa, problem, learner, expert, key, reach).hessian))
        assert np.allclose(state.hessian, np.mean(drawn, axis=0), rtol=0.0, atol=1e-12)
        assert int(state.count) == iteration + 1
        # A draw of one difference has eigenvalues of both signs, and so has the mean of a few.
        if iteration == 0:
            assert np.linalg.eigvalsh(state.hessian)[0] < 0.0
        # Nothing below λ is left, whatever the draws: λI is added exactly.
        assert float(found.smallest_eigenvalue) >= REGULARISATION - 1e-12
        assert float(found.linear_residual) <= 1e-9


def test_spsa_floors_the_eigenvalues_and_adds_the_regularisation():
    problem, learner, expert = quadratic(5, False)
    spsa, key = SPSA("frozen"), jax.random.key(3)
    found = jitted(spsa, problem, learner, expert, key)
    factors = factors_of(spsa, problem, learner, expert, key, jnp.asarray(spsa.perturbation))
    values, vectors = np.linalg.eigh(factors.hessian[0])
    floored = vectors @ np.diag(np.maximum(values, 0.0)) @ vectors.T + REGULARISATION * np.eye(EXPERT_SIZE)
    weights = np.linalg.solve(floored, np.asarray(factors.expert_gradient[0]))
    assert np.allclose(found.through_expert, -np.asarray(factors.mixed[0]).T @ weights, rtol=0.0, atol=1e-9)
    assert np.array_equal(found.through_learner, factors.learner_gradient[0])


def test_spsa_repeats_itself_for_one_key_alone():
    problem, learner, expert = quadratic(6, False)
    first, again, other = (jitted(SPSA("measured"), problem, learner, expert, jax.random.key(k)) for k in (0, 0, 1))
    assert np.array_equal(first.value, again.value)
    assert not np.array_equal(first.value, other.value)


def test_the_two_directions_of_spsa_are_independent():
    problem, learner, expert = quadratic(7, False)
    draws = 2000
    factors = factors_of(SPSA("frozen", draws=draws), problem, learner, expert, KEY, jnp.asarray(0.1))
    # An estimate is a number times Δ: its signs are those of Δ up to a common one.
    learner_signs, expert_signs = (
        np.sign(np.asarray(each[:, :1] * each[:, 1:])) for each in (factors.learner_gradient, factors.expert_gradient)
    )
    # Correlations of independent signs; their standard error is 0.022.
    assert np.abs(learner_signs.T @ expert_signs / draws).max() <= 0.1


@pytest.mark.parametrize(("perturbation", "decay"), [(0.05, 0.101), (1.0, 1.0)])
def test_the_perturbation_falls_with_the_iteration(perturbation, decay):
    # For f = l³ a central difference of width p is 3l² + p²: at l = 0 it shows p.
    problem = BilevelProblem(lambda learner, expert: (jnp.sum(learner**3), expert), 0.0)
    spsa = SPSA(perturbation=perturbation, decay=decay)
    for iteration in (0, 1, 9):
        found, _ = spsa.estimate(
            problem,
            jnp.zeros(1),
            jnp.zeros(1),
            spsa.init(jnp.zeros(1)),
            jax.random.key(iteration),
            jnp.asarray(iteration, jnp.int32),
        )
        assert float(found.value[0]) ** 0.5 == pytest.approx(perturbation / (iteration + 1.0) ** decay, rel=1e-12)
