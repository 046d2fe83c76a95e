"""Settings of all tests."""

import gc
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import jax
import pytest
from hypothesis import settings
from jax.experimental.compilation_cache import compilation_cache

from gsiirl import compilation, program_cache
from gsiirl.experiments.plans import worker

jax.config.update("jax_enable_x64", True)
# A rank or a precision that changes by accident is an error, not a broadcast.
jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_numpy_dtype_promotion", "strict")
# Programs are compiled for one or two small calls: most of the compiler's work would not pay.
jax.config.update("jax_disable_most_optimizations", True)

# The same examples in every run; no deadline, because the first example compiles.
settings.register_profile("gsiirl", deadline=None, derandomize=True)
settings.load_profile("gsiirl")


MOST_REGIONS = 50_000
"""Of memory, after a module of tests; every compiled program takes some."""


def _drop_oldest(folder: Path) -> None:
    """Keep the folder within its bound; another session may be at it, too."""
    found = []
    for path in folder.iterdir():
        with suppress(FileNotFoundError):
            found.append((path.stat(), path))
    total = sum(stat.st_size for stat, _ in found)
    for stat, path in sorted(found, key=lambda each: each[0].st_mtime):
        if total <= program_cache.LARGEST:
            return
        path.unlink(missing_ok=True)
        total -= stat.st_size


def _compile_once() -> None:
    """What one test or an earlier session has compiled is not compiled again, the smallest programs too."""
    compilation.OF_A_RUN["cpu"].clear()
    folder = program_cache.program_folder("tests")
    folder.mkdir(parents=True, exist_ok=True)
    if "PYTEST_XDIST_WORKER" not in os.environ:
        _drop_oldest(folder)
    compilation_cache.reset_cache()
    jax.config.update("jax_compilation_cache_dir", str(folder))
    # JAX's own bound looks at every file for each that it writes, and there are thousands.
    jax.config.update("jax_compilation_cache_max_size", -1)
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)


# Here and not in a fixture: modules of tests compile a little while they are imported.
_compile_once()
# JAX makes very many small objects that live on; looking through all of them again and again takes a twentieth of
# the time.
gc.set_threshold(200_000, 50, 1000)


@pytest.fixture(scope="session", autouse=True)
def _workers_are_small() -> Iterator[None]:
    """A process of tests has become large by itself; runs of a plan in it leave the programs of other tests alone."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(worker, "_is_large", lambda: False)
        yield


@pytest.fixture(scope="module", autouse=True)
def _room_for_programs() -> Iterator[None]:
    """Forget programs before Linux refuses memory: a process may have 65,530 regions of it, and JAX then crashes."""
    yield
    regions = Path("/proc/self/maps")
    if regions.exists() and regions.read_bytes().count(b"\n") > MOST_REGIONS:
        jax.clear_caches()


@pytest.fixture(scope="module")
def optax_promotion() -> Iterator[None]:
    """Precisions may mix: Adam takes powers of its step count."""
    with jax.numpy_dtype_promotion("standard"):
        yield
