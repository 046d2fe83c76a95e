"""Running an experiment: seeds vmapped, iterations in chunks, a checkpoint after every chunk."""

import importlib.metadata
import platform
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import rich.progress
from jaxtyping import Array, Key, PRNGKeyArray, PyTree

from gsiirl._version import __version__
from gsiirl.baselines.marl import marl
from gsiirl.equilibria import AbstractSolution, LogitSolution
from gsiirl.errors import InputError
from gsiirl.evaluation.reward_similarity import RewardSimilarity
from gsiirl.experiments.config import config_from_dict, config_to_dict
from gsiirl.experiments.security import SecurityConfig
from gsiirl.experiments.security_problem import SecurityProblem, build, network_of
from gsiirl.games.rollout import rollout
from gsiirl.interaction import CHUNK, interact
from gsiirl.runs import Checkpoint, RunFolder, summarise
from gsiirl.scenarios import read_network
from gsiirl.types import Sides

SAMPLE_PATHS = 3

Record = dict[str, Array]


class Algorithm(eqx.Module):
    """One algorithm on one problem, for one seed; the runner vmaps it.

    `advance(state, key, first, number)` runs iterations first, …, first + number − 1 and records each before its
    update; `learned` names the parameters to keep.
    """

    init: Callable[[PRNGKeyArray], PyTree]
    propose: Callable[[PyTree], AbstractSolution]
    advance: Callable[[PyTree, PRNGKeyArray, Array, int], tuple[PyTree, Record]]
    observe: Callable[[PyTree, AbstractSolution], Record]
    learned: Callable[[PyTree], Record]
    iterations: int


def run(config: SecurityConfig, out: Path) -> None:
    """Run an experiment into a new run folder.

    Raises:
        InputError: when the configuration's network or device, or the folder, cannot be used; nothing is written then.
    """
    config = config.resolved()
    network = network_of(config)
    with jax.enable_x64(True), _on_device(config.device):
        problem = build(config, network)
        game = {
            **network.to_json_dict(),
            "horizon": config.horizon,
            "no_op": {"learner": config.learner_no_op, "expert": config.expert_no_op},
            "truth": problem.true_weights,
        }
        folder = RunFolder.create(out, config_to_dict(config), game)
        _go_on(folder, config, problem, None)


def resume(path: Path) -> None:
    """Go on with an interrupted run; a finished one is left as it is.

    Raises:
        InputError: when the folder holds no run that can be gone on with.
    """
    folder = RunFolder.open(path)
    config = config_from_dict(folder.config, path / "config.json")
    summary = folder.summary()
    if summary is not None and summary["completed"]:
        return
    # The network as it was, wherever the file it came from may be now.
    network = read_network(path / "game.json", config.variant)
    with jax.enable_x64(True), _on_device(config.device):
        _go_on(folder, config, build(config, network), folder.load_checkpoint())


def _go_on(folder: RunFolder, config: SecurityConfig, problem: SecurityProblem, checkpoint: Checkpoint | None) -> None:
    began = time.perf_counter()
    seeds = jnp.arange(config.first_seed, config.first_seed + config.seeds)
    algorithm = _algorithm(config, problem)
    init = jax.jit(jax.vmap(lambda seed: algorithm.init(_keys(seed)[0])))
    references = {name: float(value) for name, value in jax.jit(lambda: problem.truth.references())().items()}

    def advance(states: PyTree, first: Array, number: int) -> tuple[PyTree, Record]:
        return jax.vmap(lambda seed, state: algorithm.advance(state, _keys(seed)[1], first, number))(seeds, states)

    advance = jax.jit(advance, static_argnums=2)
    if checkpoint is None:
        states, iteration, chunk = init(seeds), 0, 0
    else:
        states = _restored(checkpoint, jax.eval_shape(init, seeds))
        iteration, chunk = checkpoint.iteration, checkpoint.chunks
    with _progress() as progress:
        bar = progress.add_task(
            f"{config.algorithm}, {config.seeds} seeds", total=algorithm.iterations, completed=iteration
        )
        # The grid of chunks is fixed, so that a resumed run passes through the same ones.
        while iteration < algorithm.iterations:
            number = min(CHUNK, algorithm.iterations - iteration)
            states, record = advance(states, jnp.asarray(iteration), number)
            folder.append_metrics(chunk, _rows(record, seeds, iteration, references))
            iteration, chunk = iteration + number, chunk + 1
            folder.save_checkpoint(_stored(states), iteration, chunk)
            progress.update(bar, completed=iteration)
        _finish(folder, config, algorithm, problem, seeds, states, chunk, references)
    folder.write_environment(_environment(time.perf_counter() - began, checkpoint is not None))


def _finish(
    folder: RunFolder,
    config: SecurityConfig,
    algorithm: Algorithm,
    problem: SecurityProblem,
    seeds: Array,
    states: PyTree,
    chunk: int,
    references: dict[str, float],
) -> None:
    """The last iteration's row, sample paths, learned parameters and the summary."""

    def last(seed: Array, state: PyTree) -> tuple[Record, Any, Record]:
        proposal = algorithm.propose(state)
        record = jax.tree.map(lambda value: value[None], algorithm.observe(state, proposal))
        played = proposal.policies.learner
        deployed = Sides(played, problem.truth.expert_response(played))
        keys = jax.random.split(_keys(seed)[2], SAMPLE_PATHS)
        return record, jax.vmap(lambda key: rollout(key, problem.game, deployed))(keys), algorithm.learned(state)

    record, paths, learned = jax.jit(jax.vmap(last))(seeds, states)
    folder.append_metrics(chunk, _rows(record, seeds, algorithm.iterations, references))
    shape = paths.states.shape
    seed = np.broadcast_to(np.asarray(seeds)[:, None, None], shape)
    _, trajectory, step = np.indices(shape)
    columns = {
        "seed": seed,
        "trajectory": trajectory,
        "step": step,
        "state": np.asarray(problem.game.masks)[np.asarray(paths.states)],
        "learner_action": np.asarray(paths.actions.learner),
        "expert_action": np.asarray(paths.actions.expert),
    }
    folder.save_paths({name: column.reshape(-1) for name, column in columns.items()})
    if learned:
        bilevel = problem.learner.bilevel
        rewards = {"expert_reward": bilevel.expert_reward}
        rewards |= dict.fromkeys(("dependent_reward", "commitment"), bilevel.dependent_reward)
        folder.save_learned(
            {name: np.asarray(value) for name, value in learned.items()},
            {name: float(rewards[name].scale) for name in learned},
            {name: list(rewards[name].features.names) for name in learned},
            np.asarray(seeds).tolist(),
        )
    folder.write_summary(summarise(folder.config, folder.metrics(), completed=True))


def _algorithm(config: SecurityConfig, problem: SecurityProblem) -> Algorithm:
    truth, learner, ma_irl = problem.truth, problem.learner, problem.ma_irl
    expert_reward, dependent_reward = learner.bilevel.expert_reward, learner.bilevel.dependent_reward
    expert_similarity = RewardSimilarity.of(problem.game, expert_reward.features)
    dependent_similarity = RewardSimilarity.of(problem.game, dependent_reward.features)
    true_expert, true_dependent = (
        jnp.asarray(problem.true_weights[name]) for name in ("expert_reward", "dependent_reward")
    )

    def judged(proposal: AbstractSolution, expert_parameters: Array) -> Record:
        return {
            **truth.evaluate(proposal.policies),
            "expert_reward_pearson": expert_similarity.pearson(expert_parameters, true_expert),
            "expert_reward_epic": expert_similarity.epic(expert_parameters, true_expert, config.discount),
            "feature_gap": truth.feature_gap(proposal.policies.learner, expert_reward, expert_parameters),
            **solved(proposal),
        }

    def solved(proposal: AbstractSolution) -> Record:
        if not isinstance(proposal, LogitSolution):
            # Only an equilibrium that should have been found, and was not, makes a seed fail.
            return {"forward_residual": proposal.residual}
        return {
            "forward_residual": jnp.where(proposal.converged, proposal.residual, jnp.inf),
            "branch_folds": jnp.sum(proposal.branch_folds).astype(proposal.residual.dtype),
        }

    if config.algorithm in ("gsiirl", "paper"):
        asked = config.trajectories * (3 if config.response == "measured" else 1)

        def observe(state: PyTree, proposal: AbstractSolution) -> Record:
            fitted = learner.fitted_dependent_reward(state)
            return {
                **judged(proposal, state.expert_parameters),
                "dependent_reward_pearson": dependent_similarity.pearson(fitted, true_dependent),
                "expert_trajectories": (state.memory.count * asked).astype(fitted.dtype),
                "game_solves": state.solves.astype(fitted.dtype),
            }

        return Algorithm(
            init=learner.init,
            propose=learner.propose,
            advance=lambda state, key, first, number: interact(
                learner, problem.expert, state, key, first, number, config.trajectories, observe
            ),
            observe=observe,
            learned=lambda state: {
                "expert_reward": state.expert_parameters,
                "dependent_reward": learner.fitted_dependent_reward(state),
                "commitment": state.commitment,
            },
            iterations=config.iterations,
        )

    # Both baselines start from play of the true game.
    true_play = marl(problem.game, truth.rewards, truth.forward_model, config.discount)
    if config.algorithm == "marl":

        def observe_marl(_: PyTree, proposal: AbstractSolution) -> Record:
            return {**truth.evaluate(proposal.policies), **solved(proposal)}

        return Algorithm(
            init=lambda key: jnp.zeros(()),
            propose=lambda state: true_play,
            advance=lambda state, key, first, number: (state, {}),
            observe=observe_marl,
            learned=lambda state: {},
            iterations=0,
        )

    # As many demonstrations as GSIIRL asks for in all its interactions.
    number_of_demonstrations = config.trajectories * max(config.iterations, 1)

    def init_ma_irl(key: PRNGKeyArray) -> PyTree:
        parameter_key, demonstration_key = jax.random.split(key)
        keys = jax.random.split(demonstration_key, number_of_demonstrations)
        demonstrations = jax.vmap(lambda one: rollout(one, problem.game, true_play.policies))(keys)
        return ma_irl.init(parameter_key, demonstrations)

    def observe_ma_irl(state: PyTree, proposal: AbstractSolution) -> Record:
        asked = jnp.asarray(float(number_of_demonstrations))
        return {**judged(proposal, state.parameters.expert), "expert_trajectories": asked}

    def advance_ma_irl(state: PyTree, key: PRNGKeyArray, first: Array, number: int) -> tuple[PyTree, Record]:
        def one_iteration(state: PyTree, _: None) -> tuple[PyTree, Record]:
            return ma_irl.update(state), observe_ma_irl(state, ma_irl.propose(state))

        return jax.lax.scan(one_iteration, state, None, length=number)

    return Algorithm(
        init=init_ma_irl,
        propose=ma_irl.propose,
        advance=advance_ma_irl,
        observe=observe_ma_irl,
        learned=lambda state: {"expert_reward": state.parameters.expert, "commitment": state.parameters.learner},
        iterations=config.iterations,
    )


def _keys(seed: Array) -> Key[Array, " 3"]:
    """A seed's keys for initialisation, for its iterations, and for sample paths."""
    return jax.random.split(jax.random.key(seed), 3)


def _rows(record: Record, seeds: Array, first: int, references: dict[str, float]) -> dict[str, np.ndarray]:
    """Metrics [seeds, iterations] as columns of one row a seed and iteration."""
    shape = next(iter(record.values())).shape
    seed = np.broadcast_to(np.asarray(seeds)[:, None], shape)
    iteration = np.broadcast_to(first + np.arange(shape[1]), shape)
    constant = {name: np.full(shape, value) for name, value in references.items()}
    columns = {"seed": seed, "iteration": iteration} | {name: np.asarray(values) for name, values in record.items()}
    return {name: column.reshape(-1) for name, column in (columns | constant).items()}


def _stored(states: PyTree) -> dict[str, np.ndarray]:
    return {jax.tree_util.keystr(path): np.asarray(leaf) for path, leaf in jax.tree_util.tree_leaves_with_path(states)}


def _restored(checkpoint: Checkpoint, like: PyTree) -> PyTree:
    paths, structure = jax.tree_util.tree_flatten_with_path(like)
    try:
        leaves = [jnp.asarray(checkpoint.arrays[jax.tree_util.keystr(path)], leaf.dtype) for path, leaf in paths]
    except KeyError as error:
        raise InputError(
            "checkpoint", f"holds no {error.args[0]}", "it is of another version: begin the run anew in another folder"
        ) from error
    return jax.tree.unflatten(structure, leaves)


def _on_device(name: str) -> AbstractContextManager[object]:
    try:
        return jax.default_device(jax.devices(name)[0])
    except RuntimeError as error:
        raise InputError("--device", f"no {name} is to be had", "use --device cpu") from error


def _progress() -> rich.progress.Progress:
    return rich.progress.Progress(
        rich.progress.TextColumn("{task.description}"),
        rich.progress.BarColumn(),
        rich.progress.MofNCompleteColumn(),
        rich.progress.TimeElapsedColumn(),
        rich.progress.TimeRemainingColumn(),
    )


def _environment(seconds: float, resumed: bool) -> dict[str, Any]:
    packages = ("jax", "jaxlib", "equinox", "optax", "numpy", "polars")
    return {
        "gsiirl": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": {name: importlib.metadata.version(name) for name in packages},
        "device": str(jax.devices()[0]),
        "wall_seconds": seconds,
        "resumed": resumed,
    }
