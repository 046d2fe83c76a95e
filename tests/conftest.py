"""Settings of all tests."""

from collections.abc import Iterator

import jax
import pytest
from hypothesis import settings

jax.config.update("jax_enable_x64", True)
# A rank or a precision that changes by accident is an error, not a broadcast.
jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_numpy_dtype_promotion", "strict")

# The same examples in every run; no deadline, because the first example compiles.
settings.register_profile("gsiirl", deadline=None, derandomize=True)
settings.load_profile("gsiirl")


@pytest.fixture(scope="module")
def optax_promotion() -> Iterator[None]:
    """Precisions may mix: Adam takes powers of its step count."""
    with jax.numpy_dtype_promotion("standard"):
        yield
