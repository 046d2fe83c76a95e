"""Running an experiment: seeds vmapped in groups, iterations in chunks, a checkpoint after every chunk."""

import importlib.metadata
import math
import pkgutil
import platform
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Key, PyTree

from gsiirl._version import __version__
from gsiirl.compilation import OF_A_RUN
from gsiirl.errors import InputError
from gsiirl.experiments.config import ExperimentConfig, config_from_dict, config_to_dict
from gsiirl.experiments.prepared_run import Ending, PreparedRun, Record
from gsiirl.program.available_memory import available_memory
from gsiirl.program.command import command
from gsiirl.program.progress import Begun, Told, shown
from gsiirl.runs import Checkpoint, Environment, RunFolder, clear_lock, locked, refuse_used, summarise
from gsiirl.runs.files.atomic import refuse_unwritable
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.learned import intervals_of
from gsiirl.runs.policies import DRAWS

ANOTHER_VERSION = "it is of another version: begin the run anew in another folder"

UNSOLVED = "give a temperature nearer to the size of the rewards, or other rewards"

SEEDS_TOGETHER = {"cpu": 2, "gpu": None}
"""Of how many seeds a device computes at a time; None for all. On a CPU more would not fit its caches."""

COPIES = 4
"""Of the state of a run, while its checkpoint is written."""


Rows = Mapping[str, np.ndarray]
"""Metrics as columns: `seed`, `iteration`, and one for each metric."""


def run(
    config: ExperimentConfig, out: Path, told: Told | None = None, rows_to: Callable[[Rows], object] | None = None
) -> None:
    """Run an experiment into a new run folder; its progress is shown, or told to `told` instead.

    `rows_to` is given the metrics of every chunk when they have been written.

    Raises:
        InputError: when the configuration's game or device, or the folder, cannot be used, its seeds take too much
            memory, or the game cannot be solved with its settings (nothing is written then), or when the folder can no
            longer be written (the run can be gone on with).
    """
    config = config.resolved()
    content = config_to_dict(config)
    # Before what takes long; and again when the game is known.
    refuse_used(out, content)
    with jax.enable_x64(config.double_precision), _on_device(config.device), _shown(config, told) as tell:
        prepared = _prepare(config, None)
        refuse_used(out, content, prepared.game)
        _check_memory(config, prepared)
        references = _references(config, prepared)
        with locked(out, "--out"):
            folder = RunFolder.create(out, content, prepared.game)
            _go_on(folder, config, prepared, references, None, tell, rows_to)


def resume(path: Path, told: Told | None = None, rows_to: Callable[[Rows], object] | None = None) -> None:
    """Go on with an interrupted run; a finished one is left as it is. See `run` for what else is told.

    Raises:
        InputError: when the folder holds no run that can be gone on with, or can no longer be written.
    """
    folder = RunFolder.open(path)
    config = config_from_dict(folder.config, path / "config.json")
    if folder.is_finished():
        clear_lock(path)
        return
    with (
        jax.enable_x64(config.double_precision),
        _on_device(config.device),
        _shown(config, told) as tell,
        locked(path, str(path), "make it writable, then try again"),
    ):
        # Another process may have finished it before it was locked.
        if folder.is_finished():
            return
        checkpoint = folder.load_checkpoint()
        _refuse_other(folder, checkpoint, config)
        prepared = _prepare(config, path / "game.json")
        _go_on(folder, config, prepared, _references(config, prepared), checkpoint, tell, rows_to)


def _refuse_other(folder: RunFolder, checkpoint: Checkpoint | None, config: ExperimentConfig) -> None:
    """See that a checkpoint is one of this run, and that the metrics before it are there.

    Raises:
        InputError: it is none, or some of the metrics are missing.
    """
    if checkpoint is None:
        return
    iteration = checkpoint.iteration
    if iteration > config.iterations:
        raise InputError("checkpoint", f"is of iteration {iteration} of {config.iterations}", ANOTHER_VERSION)
    metrics = folder.metrics(checkpoint.chunks)
    seeds = [*range(config.first_seed, config.first_seed + config.seeds)]
    if {*metrics["iteration"]} != {*range(iteration)} or metrics["seed"].unique().sort().to_list() != seeds:
        problem = f"does not hold {iteration} iterations of {config.seeds} seeds"
        raise InputError(str(folder.path / "metrics"), problem, START_AGAIN)


def _prepare(config: ExperimentConfig, saved_game: Path | None) -> PreparedRun:
    """What the experiment's own `prepare` makes of the configuration; only that experiment's code is imported."""
    return pkgutil.resolve_name(config.preparation)(config, saved_game)


def _check_memory(config: ExperimentConfig, prepared: PreparedRun) -> None:
    """Refuse more seeds than fit into half of the memory that is free, with the copies that a checkpoint makes."""
    state = jax.eval_shape(lambda: prepared.algorithm.init(_keys(jnp.asarray(0))[0]))
    each = COPIES * sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(state))
    available = available_memory()
    if available is not None and config.seeds * each > available / 2:
        problem = f"{config.seeds:,} take {config.seeds * each / 1e9:,.1f} GB of memory, and half of what is free"
        mend = f"use at most {int(available / 2 / each):,}"
        raise InputError("--seeds", f"{problem} is {available / 2e9:,.1f} GB", mend)


def _references(config: ExperimentConfig, prepared: PreparedRun) -> dict[str, float]:
    """What all seeds are compared with.

    Raises:
        InputError: a number of it is none, so that every figure of the run would be none.
    """
    compiled = jax.jit(lambda: prepared.references(), compiler_options=OF_A_RUN[config.device])
    references = {name: float(value) for name, value in compiled().items()}
    for name, value in references.items():
        if not math.isfinite(value):
            raise InputError(config.experiment, f"the game cannot be solved: {name} is {value}", UNSOLVED)
    return references


def _go_on(
    folder: RunFolder,
    config: ExperimentConfig,
    prepared: PreparedRun,
    references: dict[str, float],
    checkpoint: Checkpoint | None,
    tell: Told,
    rows_to: Callable[[Rows], object] | None,
) -> None:
    began = time.perf_counter()
    tell(0 if checkpoint is None else checkpoint.iteration, prepared.iterations)
    seeds = jnp.arange(config.first_seed, config.first_seed + config.seeds)
    algorithm, iterations = prepared.algorithm, prepared.iterations
    compiled = partial(jax.jit, compiler_options=OF_A_RUN[config.device])
    every = partial(over_seeds, SEEDS_TOGETHER[config.device])
    init = compiled(lambda seeds: every(lambda seed: algorithm.init(_keys(seed)[0]), seeds))

    # The seeds are arguments: as constants they would make another program for every first seed.
    def advance(seeds: Array, states: PyTree, first: Array, number: int) -> tuple[PyTree, Record]:
        return every(lambda seed, state: algorithm.advance(state, _keys(seed)[1], first, number), seeds, states)

    def finish(seeds: Array, states: PyTree) -> Ending:
        return every(lambda seed, state: algorithm.finish(state, _keys(seed)[2]), seeds, states)

    advance, finish = compiled(advance, static_argnums=3), compiled(finish)
    iteration, chunk = (0, 0) if checkpoint is None else (checkpoint.iteration, checkpoint.chunks)
    states = init(seeds) if checkpoint is None else _restored(checkpoint, jax.eval_shape(init, seeds))
    # The grid of chunks is fixed, so that a resumed run passes through the same ones.
    while iteration < iterations:
        number = min(prepared.chunk, iterations - iteration)
        states, record = advance(seeds, states, jnp.asarray(iteration), number)
        rows = _rows(record, seeds, iteration, references)
        with _written(folder):
            folder.append_metrics(chunk, rows)
            iteration, chunk = iteration + number, chunk + 1
            folder.save_checkpoint(_stored(states), iteration, chunk)
        if rows_to is not None:
            rows_to(rows)
        tell(iteration, iterations)
    ending = finish(seeds, states)
    with _written(folder):
        last = _finish(folder, prepared, ending, seeds, chunk, references)
        folder.write_environment(_environment(time.perf_counter() - began, checkpoint is not None))
        # Last: a run with a summary is over.
        folder.write_summary(summarise(folder.config, folder.metrics(), completed=True))
    if rows_to is not None:
        rows_to(last)


def _written(folder: RunFolder) -> AbstractContextManager[None]:
    """What is written meanwhile may fail; the run can be gone on with from what was written before."""
    mend = f"make room or allow it, then go on with `{command('resume', folder.path)}`"
    return refuse_unwritable(str(folder.path), folder.path, mend)


def over_seeds(together: int | None, function: Callable[..., PyTree], seeds: Array, *states: PyTree) -> PyTree:
    """What `function` makes of every seed (and its state), vmapped over `together`, or as many as divide all."""
    if together is None:
        return jax.vmap(function)(seeds, *states)
    # A last group that is not full would be a program of its own, and compiled apart.
    size = math.gcd(together, len(seeds))
    return jax.lax.map(lambda each: function(*each), (seeds, *states), batch_size=size)


def _finish(
    folder: RunFolder, prepared: PreparedRun, ending: Ending, seeds: Array, chunk: int, references: dict[str, float]
) -> Rows:
    """Write the last iteration's row, which is returned, sample paths, what was learned, and the policies."""
    record = {name: value[:, None] for name, value in ending.record.items()}
    rows = _rows(record, seeds, prepared.iterations, references)
    folder.append_metrics(chunk, rows)
    folder.save_paths(_table(ending.paths, seeds, ("trajectory", "step")))
    if ending.reward_map:
        folder.save_reward_map(_table(ending.reward_map, seeds, ()))
    if ending.learned:
        intervals = None
        if DRAWS in ending.policies:
            scale = prepared.parameters["expert_reward"].scale
            draws, priors = (np.asarray(each) for each in (ending.policies[DRAWS], ending.record["prior_deviation"]))
            intervals = intervals_of(scale * draws, scale * priors)
        folder.save_learned(
            {name: np.asarray(value) for name, value in ending.learned.items()},
            {name: prepared.parameters[name].scale for name in ending.learned},
            {name: list(prepared.parameters[name].names) for name in ending.learned},
            np.asarray(seeds).tolist(),
            {} if intervals is None else {"expert_reward": intervals},
        )
    if ending.policies:
        folder.save_policies({name: np.asarray(value) for name, value in ending.policies.items()})
    return rows


def _keys(seed: Array) -> Key[Array, " 3"]:
    """A seed's keys for initialisation, for its iterations, and for its end."""
    return jax.random.split(jax.random.key(seed), 3)


def _rows(record: Record, seeds: Array, first: int, references: dict[str, float]) -> dict[str, np.ndarray]:
    """Metrics [seeds, iterations] as columns of one row a seed and iteration."""
    table = _table(record, seeds, ("iteration",))
    table["iteration"] += first
    return table | {name: np.full(table["seed"].shape, value) for name, value in references.items()}


def _table(columns: Mapping[str, Array], seeds: Array, axes: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Arrays of one shape [seeds, ...] as columns of one row an entry, after its seed and its place along `axes`."""
    shape = next(iter(columns.values())).shape
    places = dict(zip(("seed", *axes), np.indices(shape), strict=False))
    places["seed"] = np.asarray(seeds)[places["seed"]]
    table = places | {name: np.asarray(values) for name, values in columns.items()}
    return {name: column.reshape(-1) for name, column in table.items()}


def _stored(states: PyTree) -> dict[str, np.ndarray]:
    """The states' arrays, each named after its place in the tree."""
    named = jax.tree_util.tree_leaves_with_path(states)
    return {
        jax.tree_util.keystr(path): np.asarray(jax.random.key_data(leaf) if _is_key(leaf) else leaf)
        for path, leaf in named
    }


def _restored(checkpoint: Checkpoint, like: PyTree) -> PyTree:
    """The states that were stored; `like` has their tree, types and shapes."""
    named, structure = jax.tree_util.tree_flatten_with_path(like)
    leaves = []
    for path, leaf in named:
        name = jax.tree_util.keystr(path)
        stored = checkpoint.arrays.get(name)
        if stored is None:
            raise InputError("checkpoint", f"holds no {name}", ANOTHER_VERSION)
        raw = jax.eval_shape(jax.random.key_data, leaf) if _is_key(leaf) else leaf
        if (stored.shape, stored.dtype) != (raw.shape, raw.dtype):
            held = f"{stored.dtype} of shape {stored.shape}, not {raw.dtype} of shape {raw.shape}"
            raise InputError("checkpoint", f"holds {name} as {held}", ANOTHER_VERSION)
        leaves.append(jax.random.wrap_key_data(jnp.asarray(stored)) if _is_key(leaf) else jnp.asarray(stored))
    return jax.tree.unflatten(structure, leaves)


def _is_key(leaf: Array | jax.ShapeDtypeStruct) -> bool:
    return jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key)


def _on_device(name: str) -> AbstractContextManager[object]:
    try:
        return jax.default_device(jax.devices(name)[0])
    except RuntimeError as error:
        raise InputError("--device", f"no {name} is to be had", "use --device cpu") from error


@contextmanager
def _shown(config: ExperimentConfig, told: Told | None) -> Iterator[Told]:
    """Who is told of the progress: `told`, or whoever looks at the screen."""
    if told is not None:
        yield told
        return
    with shown() as progress:
        yield Begun(progress, title(config)).tell


def title(config: ExperimentConfig) -> str:
    """What the progress of a run is shown under."""
    return f"{config.experiment}, {config.algorithm}, {config.seeds} seed{'s' * (config.seeds > 1)}"


def _environment(seconds: float, resumed: bool) -> Environment:
    packages = ("jax", "jaxlib", "equinox", "optax", "numpy", "polars")
    return Environment(
        gsiirl=__version__,
        python=platform.python_version(),
        platform=platform.platform(),
        packages={name: importlib.metadata.version(name) for name in packages},
        device=str(jax.devices()[0]),
        wall_seconds=seconds,
        resumed=resumed,
        finished=datetime.now(UTC).isoformat(timespec="seconds"),
    )
