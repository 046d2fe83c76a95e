"""Settings of all tests."""

from collections.abc import Iterator

import jax
import pytest
from hypothesis import settings
from jax.experimental.compilation_cache import compilation_cache

jax.config.update("jax_enable_x64", True)
# A rank or a precision that changes by accident is an error, not a broadcast.
jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_numpy_dtype_promotion", "strict")
# Programs are compiled for one or two small calls: most of the compiler's work would not pay.
jax.config.update("jax_disable_most_optimizations", True)

# The same examples in every run; no deadline, because the first example compiles.
settings.register_profile("gsiirl", deadline=None, derandomize=True)
settings.load_profile("gsiirl")


@pytest.fixture(scope="session", autouse=True)
def _compile_once(tmp_path_factory: pytest.TempPathFactory) -> None:
    """What several tests compile is compiled once, in a folder of this process's own; the programs of runs too."""
    from gsiirl import compilation

    compilation.OF_A_RUN["cpu"].clear()
    compilation_cache.reset_cache()
    jax.config.update("jax_compilation_cache_dir", str(tmp_path_factory.mktemp("compiled")))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.2)


@pytest.fixture(scope="module")
def optax_promotion() -> Iterator[None]:
    """Precisions may mix: Adam takes powers of its step count."""
    with jax.numpy_dtype_promotion("standard"):
        yield
