"""Draws from the posterior of a small game agree with those of BlackJAX (recorded by scripts/record_blackjax.py)."""

from pathlib import Path

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jaxtyping import Array

from gsiirl.games import TabularGame
from gsiirl.irl.conditional_likelihood import ConditionalLikelihood, Seen
from gsiirl.irl.memory import Memory
from gsiirl.irl.posterior import Inference
from gsiirl.rewards.linear import TabularFeatures

RECORDED = dict(np.load(Path(__file__).parents[1] / "data" / "blackjax_posterior.npz"))
NUMBER = 1000


@pytest.fixture(scope="module")
def drawn() -> tuple[np.ndarray, np.ndarray]:
    """Draws by Hamiltonian Monte Carlo, and those that a result keeps."""
    horizon, states = RECORDED["counts"].shape[1:3]
    game = TabularGame.from_arrays(RECORDED["transitions"], initial=np.full(states, 1.0 / states), horizon=horizon)
    features = TabularFeatures(table=RECORDED["features"], names=("a", "b", "c", "d"))
    model = ConditionalLikelihood(game, features, float(RECORDED["discount"]))
    inference = jax.tree.map(jnp.asarray, Inference(model, RECORDED["deviation"]))
    key = jax.random.key(0)
    memory = Memory.empty(4, Seen(jnp.asarray(RECORDED["policies"][0]), jnp.zeros(RECORDED["counts"].shape[1:])))
    for policy, counts in zip(RECORDED["policies"], RECORDED["counts"], strict=True):
        memory = memory.remember(key, Seen(jnp.asarray(policy), jnp.asarray(counts)))

    @eqx.filter_jit
    def both(inference: Inference, memory: Memory[Seen]) -> tuple[Array, Array]:
        posterior = inference.fit(inference.start(jnp.dtype(float)), memory, key)
        chains = inference.hamiltonian(posterior, memory, NUMBER, 200, key)
        return chains, inference.equal_draws(posterior, memory, NUMBER, key)

    chains, kept = both(inference, memory)
    return np.asarray(chains), np.asarray(kept)


@pytest.mark.slow
@pytest.mark.parametrize("which", [0, 1])
def test_means_deviations_and_quantiles_are_those_of_blackjax(drawn: tuple[np.ndarray, np.ndarray], which: int) -> None:
    draws, deviation = drawn[which], np.sqrt(np.diag(RECORDED["covariance"]))
    error = np.hypot(deviation / NUMBER**0.5, RECORDED["errors"])
    assert (np.abs(draws.mean(axis=0) - RECORDED["mean"]) < 4.0 * error).all()
    np.testing.assert_allclose(draws.std(axis=0, ddof=1), deviation, rtol=0.1)
    # The standard error of a 5 % quantile of 1000 normal draws is 0.07 deviations.
    apart = np.quantile(draws, [0.05, 0.5, 0.95], axis=0) - RECORDED["quantiles"]
    assert (np.abs(apart) < 4.0 * 0.07 * deviation).all()


def test_the_posterior_is_no_gaussian_so_that_the_comparison_can_fail() -> None:
    low, middle, high = RECORDED["quantiles"]
    assert np.max(np.abs((high - middle) / (middle - low) - 1.0)) > 0.1
