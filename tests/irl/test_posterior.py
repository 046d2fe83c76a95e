"""The posterior: its maximum, the prior that the evidence chooses, draws, and the way without matrices."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from commitment_oracle import Batch, Floats, response
from jaxtyping import Array
from small_games import HORIZON, JOINT, TERMINAL, finite_game, tabular

from gsiirl.games import TabularGame
from gsiirl.irl import posterior as posterior_module
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood, Seen
from gsiirl.irl.memory import Memory
from gsiirl.irl.posterior import FIRST_DEVIATION, Inference, Posterior
from gsiirl.rewards.linear import IndicatorFeatures, TabularFeatures

GAME = finite_game(3, temperature=0.5)
KEY = jax.random.key(0)
CHAINS = 1000


def inference_of(model: ConditionalLikelihood, deviation: float | None, tolerance: float = 1e-3) -> Inference:
    prior = None if deviation is None else np.asarray(deviation)
    return jax.tree.map(jnp.asarray, Inference(model, prior, tolerance))


def small_inference(deviation: float | None, tolerance: float = 1e-3) -> Inference:
    return inference_of(
        ConditionalLikelihood(tabular(GAME), IndicatorFeatures(shape=JOINT, names=()), 0.9), deviation, tolerance
    )


@pytest.fixture(scope="module")
def memory() -> Memory[Seen]:
    """What was seen in three interactions of 60 episodes."""
    random = np.random.default_rng(1)
    policies = Batch(GAME).tidy(random.gamma(0.5, size=(3, HORIZON, *JOINT[:2])) + 1e-6)
    shape = (HORIZON, JOINT[0], JOINT[2])
    kept = Memory.empty(4, Seen(jnp.asarray(policies[0]), jnp.zeros(shape)))
    for policy in policies:
        answer, counts = response(GAME, policy), np.zeros(shape)
        for time, state in np.ndindex(HORIZON, JOINT[0]):
            if not TERMINAL[state]:
                counts[time, state] = random.multinomial(20, answer[time, state])
        kept = kept.remember(KEY, Seen(jnp.asarray(policy), jnp.asarray(counts)))
    return kept


@eqx.filter_jit
def fit(inference: Inference, before: Posterior, memory: Memory[Seen]) -> Posterior:
    return inference.fit(before, memory, KEY)


def fitted(inference: Inference, memory: Memory[Seen]) -> Posterior:
    return fit(inference, inference.start(jnp.dtype(float)), memory)


def one_shot(counts: Floats, deviation: float) -> tuple[Inference, Memory[Seen]]:
    """One decision between two actions and one weight: the reward of the second; a learner with one action."""
    game = TabularGame.from_arrays(np.ones((1, 1, 2, 1)), initial=[1.0], horizon=1)
    model = ConditionalLikelihood(game, TabularFeatures(table=np.array([[[[0.0], [1.0]]]]), names=()), 1.0)
    seen = Seen(jnp.ones((1, 1, 1)), jnp.asarray(counts).reshape(1, 1, 2))
    return inference_of(model, deviation), Memory.empty(1, seen).remember(KEY, seen)


def exact_moments(counts: Floats, deviation: float) -> tuple[float, float]:
    """Mean and standard deviation of the posterior of `one_shot`, by summing over a fine grid."""
    theta = np.linspace(-40, 40, 400_001)
    log = counts[1] * theta - counts.sum() * np.logaddexp(0, theta) - 0.5 * (theta / deviation) ** 2
    weights = np.exp(log - log.max())
    mean = (weights * theta).sum() / weights.sum()
    return mean, float(np.sqrt((weights * (theta - mean) ** 2).sum() / weights.sum()))


def test_before_anything_was_seen_there_is_the_prior() -> None:
    start = small_inference(None).start(jnp.dtype(float))
    np.testing.assert_array_equal(start.mean, np.zeros(18))
    assert start.precision is not None
    np.testing.assert_allclose(start.precision, np.eye(18) / FIRST_DEVIATION**2)
    np.testing.assert_allclose(small_inference(0.5).start(jnp.dtype(float)).prior_precision, 4.0)


def test_the_estimate_is_the_maximum_and_the_prior_is_the_evidences(memory: Memory[Seen]) -> None:
    inference = small_inference(None)
    found = fitted(inference, memory)
    assert bool(found.converged)
    assert float(found.decrement) <= 1e-3
    # It ends where it has converged.
    assert int(found.steps) < 15
    fisher = np.asarray(eqx.filter_jit(inference.likelihood.fisher)(found.mean, memory))
    value, gradient = eqx.filter_jit(inference.likelihood.value_and_gradient)(found.mean, memory)
    alpha, theta = float(found.prior_precision), np.asarray(found.mean)
    precision = fisher + alpha * np.eye(18)
    assert found.precision is not None
    np.testing.assert_allclose(found.precision, precision, atol=1e-9)
    slope = np.asarray(gradient) - alpha * theta
    np.testing.assert_allclose(
        found.decrement, np.sqrt(slope @ np.linalg.solve(precision, slope)), rtol=1e-3, atol=1e-9
    )
    np.testing.assert_allclose(found.log_density, value - 0.5 * alpha * theta @ theta, rtol=1e-9)
    determined = 18 - alpha * np.trace(np.linalg.inv(precision))
    assert 0 < determined < 18
    np.testing.assert_allclose(alpha, (determined + 0.5) / (theta @ theta + 0.5 * 3.0**2), rtol=0.02)


def test_a_fit_comes_back_from_where_a_whole_step_leads_too_far() -> None:
    inference, memory = one_shot(np.array([40.0, 60.0]), 3.0)
    far = eqx.tree_at(lambda at: at.mean, inference.start(jnp.dtype(float)), jnp.array([30.0]))
    found, wanted = fit(inference, far, memory), fitted(inference, memory)
    assert bool(found.converged)
    np.testing.assert_allclose(found.mean, wanted.mean, atol=1e-3)


def test_a_costly_fisher_information_is_computed_anew_at_times() -> None:
    held, steps = np.array([1, 8, 9, 15, 16]), np.arange(-1, 17)
    every_pair = jax.vmap(jax.vmap(posterior_module.counted_anew, (None, 0)), (0, None))
    expected = np.zeros((5, 18))
    # At first of all interactions up to the eighth, and then with every eighth; else of the newest alone.
    expected[:, 0] = [1, 8, 1, 1, 16]
    # And in every eighth step of all.
    expected[:, [8, 16]] = held[:, None]
    np.testing.assert_array_equal(every_pair(jnp.asarray(held), jnp.asarray(steps)), expected)


def test_an_old_fisher_information_leads_to_the_same_estimate(
    memory: Memory[Seen], monkeypatch: pytest.MonkeyPatch
) -> None:
    inference = small_inference(1.0)
    # Interactions one after the other, until F is not computed anew in every iteration any more.
    seen = [jax.tree.map(lambda leaf, place=place: leaf[place], memory.kept) for place in (0, 1)]
    monkeypatch.setattr(posterior_module, "RENEWED", 2)
    monkeypatch.setattr(ConditionalLikelihood, "costly", True)
    fit = eqx.filter_jit(lambda before, memory: inference.fit(before, memory, KEY))
    growing = Memory.empty(6, seen[0])
    stale = inference.start(jnp.dtype(float))
    for place in (0, 1, 0, 1, 0):
        growing = growing.remember(KEY, seen[place])
        stale = fit(stale, growing)
    assert bool(stale.converged)
    monkeypatch.setattr(ConditionalLikelihood, "costly", False)
    fresh = eqx.filter_jit(lambda before, memory: inference.fit(before, memory, jax.random.key(1)))(stale, growing)
    assert bool(fresh.converged)
    assert stale.precision is not None
    assert fresh.precision is not None
    away = np.asarray(stale.mean - fresh.mean)
    assert np.sqrt(away @ np.asarray(fresh.precision) @ away) < 3e-3
    np.testing.assert_allclose(stale.precision, fresh.precision, rtol=0, atol=0.1 * np.abs(fresh.precision).max())
    assert not np.array_equal(stale.precision, fresh.precision)


@pytest.mark.slow
def test_without_matrices_one_weight_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    inference, memory = one_shot(np.array([40.0, 60.0]), 3.0)
    dense = fitted(inference, memory)
    monkeypatch.setattr(posterior_module, "DENSE", 0)
    # From 0, and from where a whole step leads too far.
    begun = inference.start(jnp.dtype(float))
    fit = eqx.filter_jit(lambda mean: inference.fit(eqx.tree_at(lambda at: at.mean, begun, mean), memory, KEY))
    for mean in (0.0, 30.0):
        free = fit(jnp.array([mean]))
        assert free.precision is None
        assert bool(free.converged)
        np.testing.assert_allclose(free.mean, dense.mean, atol=1e-4)
        np.testing.assert_allclose(free.log_density, dense.log_density, atol=1e-6)


@pytest.mark.slow
def test_without_matrices_the_estimate_is_the_same(memory: Memory[Seen], monkeypatch: pytest.MonkeyPatch) -> None:
    dense = fitted(small_inference(1.5, 1e-5), memory)
    monkeypatch.setattr(posterior_module, "DENSE", 0)
    free = fitted(small_inference(1.5, 1e-5), memory)
    assert free.precision is None
    assert bool(free.converged)
    away = np.asarray(free.mean - dense.mean)
    assert np.sqrt(away @ np.asarray(dense.precision) @ away) <= 1e-3
    np.testing.assert_allclose(free.log_density, dense.log_density, rtol=1e-9)


@pytest.mark.slow
def test_without_matrices_draws_have_the_same_covariance(memory: Memory[Seen], monkeypatch: pytest.MonkeyPatch) -> None:
    dense = fitted(small_inference(1.5), memory)
    monkeypatch.setattr(posterior_module, "DENSE", 0)
    free, number = small_inference(1.5), 1000
    found = fitted(free, memory)
    draws = eqx.filter_jit(free.draws)(found, memory, number, KEY)
    covariance = np.linalg.inv(np.asarray(dense.precision))
    away = np.asarray(draws.values) - np.asarray(found.mean)
    scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    # An entry's standard error is at most sqrt(2 / number) of its scale.
    assert (np.abs(away.T @ away / number - covariance) / scale <= 5 * np.sqrt(2 / number)).all()
    assert (np.abs(away.mean(0)) <= 5 * np.sqrt(np.diag(covariance) / number)).all()
    np.testing.assert_allclose(jnp.sum(draws.weights), 1.0, atol=1e-12)


@pytest.mark.slow
def test_without_matrices_the_evidence_chooses_the_same_prior_on_average(
    memory: Memory[Seen], monkeypatch: pytest.MonkeyPatch
) -> None:
    dense = fitted(small_inference(None, 1e-5), memory)
    monkeypatch.setattr(posterior_module, "DENSE", 0)
    free, before = small_inference(None, 1e-5), eqx.tree_at(lambda at: at.precision, dense, None)
    keys = jax.random.split(KEY, 200)
    found = eqx.filter_jit(lambda: jax.lax.map(lambda key: free.fit(before, memory, key).prior_precision, keys))()
    # One draw stands for a trace, so that each differs.
    ratios = np.asarray(found) / float(dense.prior_precision)
    assert abs(ratios.mean() - 1.0) <= 5 * ratios.std() / np.sqrt(len(ratios)) + 0.02


@pytest.mark.parametrize(("counts", "deviation"), [([0.0, 3.0], 3.0), ([40.0, 60.0], 3.0), ([0.0, 1.0], 10.0)])
def test_weighted_draws_are_of_the_posterior_itself(counts: list[float], deviation: float) -> None:
    inference, memory = one_shot(np.array(counts), deviation)
    draws = eqx.filter_jit(inference.draws)(fitted(inference, memory), memory, 20_000, KEY)
    values, weights = np.asarray(draws.values[:, 0]), np.asarray(draws.weights)
    mean, spread = exact_moments(np.array(counts), deviation)
    error = spread / np.sqrt(float(draws.effective))
    assert 1000 < float(draws.effective) <= 20_000
    assert abs(weights @ values - mean) <= 5 * error
    assert abs(np.sqrt(weights @ (values - mean) ** 2) - spread) <= 10 * error


@eqx.filter_jit
def chains(inference: Inference, memory: Memory[Seen], rounds: Array) -> Array:
    """Where Hamiltonian Monte Carlo ends, from the estimate."""
    return inference.hamiltonian(
        inference.fit(inference.start(jnp.dtype(float)), memory, KEY), memory, CHAINS, rounds, KEY
    )


@pytest.mark.parametrize(("counts", "deviation"), [([0.0, 3.0], 3.0), ([40.0, 60.0], 3.0), ([1.0, 1.0], 0.2)])
def test_hamiltonian_draws_are_of_the_posterior_itself(counts: list[float], deviation: float) -> None:
    inference, memory = one_shot(np.array(counts), deviation)
    mean, spread = exact_moments(np.array(counts), deviation)
    # Few steps are enough: where the integration is off, most are refused, and a chain stays near its beginning.
    for rounds in (6, 60):
        values = chains(inference, memory, jnp.asarray(rounds))
        assert abs(float(jnp.mean(values)) - mean) <= 5 * spread / np.sqrt(CHAINS)
        assert abs(float(jnp.std(values)) - spread) <= 5 * spread / np.sqrt(CHAINS)


def test_no_rounds_leave_the_chains_at_the_estimate() -> None:
    inference, memory = one_shot(np.array([1.0, 3.0]), 3.0)
    values = chains(inference, memory, jnp.asarray(0))
    np.testing.assert_allclose(values, np.broadcast_to(fitted(inference, memory).mean, (CHAINS, 1)))


@pytest.mark.parametrize(("counts", "deviation"), [([40.0, 60.0], 3.0), ([0.0, 3.0], 3.0), ([0.0, 1.0], 30.0)])
def test_equal_draws_have_the_quantiles_of_the_posterior(counts: list[float], deviation: float) -> None:
    # In the last case the posterior is far from Gaussian, and chains take the place of weighted draws.
    inference, memory = one_shot(np.array(counts), deviation)
    before = fitted(inference, memory)
    draws = eqx.filter_jit(inference.equal_draws)(before, memory, 2000, KEY)
    theta = np.linspace(-150, 150, 600_001)
    log = counts[1] * theta - sum(counts) * np.logaddexp(0, theta) - 0.5 * (theta / deviation) ** 2
    distribution = np.cumsum(np.exp(log - log.max()))
    for level in (0.05, 0.5, 0.95):
        share = np.interp(float(jnp.quantile(draws[:, 0], level)), theta, distribution / distribution[-1])
        assert abs(share - level) <= 5 * np.sqrt(level * (1 - level) / 1000)
