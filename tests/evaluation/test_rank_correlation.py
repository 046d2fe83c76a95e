import jax.numpy as jnp
import numpy as np
import pytest
import scipy.stats

from gsiirl.evaluation.rank_correlation import spearman


@pytest.mark.parametrize("seed", range(5))
def test_it_is_that_of_scipy_with_ties_too(seed: int) -> None:
    random = np.random.default_rng(seed)
    first, second = random.integers(0, 5, (2, 6, 7)).astype(float) if seed % 2 else random.normal(size=(2, 6, 7))
    expected = np.asarray(scipy.stats.spearmanr(first.ravel(), second.ravel()))[0]
    assert float(spearman(jnp.asarray(first), jnp.asarray(second))) == pytest.approx(expected, abs=1e-12)


def test_rounding_breaks_no_tie_and_a_constant_is_like_nothing() -> None:
    values = jnp.asarray([0.1 + 0.2, 0.3, 1.0, 2.0])
    assert float(spearman(values, jnp.asarray([0.0, 0.0, 1.0, 2.0]))) == pytest.approx(1.0)
    assert float(spearman(values, jnp.full(4, 0.7))) == 0.0
