"""`gsiirl.load`: a result from where `Result.save` wrote it, or from a run folder of a finite experiment."""

from dataclasses import dataclass
from pathlib import Path

import jax
import numpy as np
import polars

from gsiirl.errors import InputError
from gsiirl.experiments.config import config_from_dict
from gsiirl.experiments.game.config import GameConfig
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.front_door.result import MEND, Result, check_shapes
from gsiirl.front_door.saved_problem import problem_from
from gsiirl.problems.problem import Problem
from gsiirl.program.command import command
from gsiirl.program.presence import is_file, is_folder
from gsiirl.runs import RunFolder
from gsiirl.runs.files.array_file import read_versioned_arrays
from gsiirl.runs.files.checksum import carries_checksum
from gsiirl.runs.files.damage import refuse_damaged, refuse_unreadable
from gsiirl.runs.files.json_file import as_typed, read_versioned_json
from gsiirl.runs.files.table_file import read_table
from gsiirl.runs.policies import DRAWS


def load(folder: str | Path, seed: int | None = None) -> Result:
    """A result that `Result.save` wrote, or one seed of a run folder of `gsiirl run`.

    Raises:
        InputError: the folder holds neither, is damaged, or has no such seed.
    """
    path, mend = Path(folder), "give one that Result.save wrote, or a run folder"
    with refuse_unreadable("folder", path, mend):
        if not is_folder(path):
            raise InputError("folder", f"{path} is no folder", mend)
        if is_file(path / "config.json"):
            return load_run(path, seed)
        if not is_file(path / "result.json"):
            raise InputError("folder", f"{path} holds no result.json", mend)
    content = read_versioned_json(path / "result.json", MEND)
    saved = as_typed(_Saved, content, path / "result.json", MEND)
    carries = carries_checksum(content, path)
    arrays, _ = read_versioned_arrays(path / "result.safetensors", MEND, carries)
    history = read_table(path / "history.parquet", MEND, carries)
    if seed is not None and seed != saved.seed:
        raise InputError("seed", f"{seed} is not in {path}", f"it holds seed {saved.seed}")
    with refuse_damaged(path / "result.json", MEND):
        problem = problem_from(content, arrays)
        _check_horizon(arrays["policy"], problem, path)
        result = Result.learned(
            problem=problem,
            seed=saved.seed,
            trajectories=saved.trajectories,
            policy=arrays["policy"],
            expert_policy=arrays["expert_policy"],
            expert_weights=arrays["expert_weights"],
            dependent_weights=arrays["dependent_weights"],
            # Results of earlier versions have none.
            draws=arrays.get("expert_draws", np.zeros((0, *arrays["expert_weights"].shape))),
            history=history,
            played=arrays["played"],
            answers=arrays.get("answers", np.zeros((0, *arrays["expert_policy"].shape))),
            effective_draws=saved.effective_draws,
            sampled=saved.sampled,
        )
    check_shapes(result, path)
    return result


@dataclass(frozen=True)
class _Saved:
    """What `result.json` holds besides the problem."""

    seed: int
    trajectories: int
    effective_draws: float
    sampled: bool


def load_run(path: Path, seed: int | None) -> Result:
    """One seed of a finished run of `gsiirl run security` or `gsiirl run game`; the first, where none is named.

    Raises:
        InputError: the run has not ended, keeps no policy, or has no such seed.
    """
    folder = RunFolder.open(path)
    config = config_from_dict(folder.config, path / "config.json")
    if not isinstance(config, GameConfig | SecurityConfig):
        raise InputError("folder", f"{path} holds a run of {config.experiment}", "only finite games are loaded")
    summary, policies, learned = folder.summary(), folder.load_policies(), folder.load_learned()
    if summary is None or policies is None or not {"learner.table", "expert.table"} <= policies.keys():
        finish = f"finish it with {command('resume', path)}, or run it anew"
        raise InputError("folder", f"{path} keeps no policy", finish)
    if learned is None or not {"expert_reward", "dependent_reward"} <= learned.arrays.keys():
        raise InputError("folder", f"{path} is a run of {config.algorithm}, which learns no rewards", "load another")
    chosen = summary.seeds[0] if seed is None else seed
    if chosen not in summary.seeds:
        raise InputError("seed", f"{chosen} is not in {path}", f"choose from {', '.join(map(str, summary.seeds))}")
    place = summary.seeds.index(chosen)
    problem = _problem(config, path)
    history = folder.metrics().filter(polars.col("seed") == chosen).drop("seed")
    effective = history["effective_draws"][-1] if "effective_draws" in history.columns else np.nan
    policy = policies["learner.table"][place]
    # Runs of earlier versions have none, nor have those without a posterior.
    drawn = policies.get(DRAWS, np.zeros((len(summary.seeds), 0, learned.arrays["expert_reward"].shape[1])))
    draws = learned.scales["expert_reward"] * drawn[place]
    _check_horizon(policy, problem, path)
    result = Result.learned(
        problem=problem,
        seed=chosen,
        trajectories=config.trajectories,
        policy=policy,
        expert_policy=policies["expert.table"][place],
        expert_weights=learned.weights("expert_reward")[place],
        dependent_weights=learned.weights("dependent_reward")[place],
        draws=draws,
        history=history,
        played=np.zeros((0, *policy.shape)),
        answers=np.zeros((0, *policies["expert.table"][place].shape)),
        effective_draws=float(effective),
        sampled=False,
    )
    check_shapes(result, path)
    return result


def _check_horizon(policy: np.ndarray, problem: Problem, path: Path) -> None:
    """Refuse another horizon than the policy's, before anything is done for each step of it: it may be any number."""
    if policy.shape[:1] != (problem.game.horizon,):
        raise InputError(str(path), f"is damaged: its policy is not of {problem.game.horizon} steps", MEND)


def _problem(config: GameConfig | SecurityConfig, path: Path) -> Problem:
    if isinstance(config, GameConfig):
        from gsiirl.experiments.game.run import own_game

        return own_game(config, path / "game.json").problem
    from gsiirl.experiments.security.problem import build, told
    from gsiirl.scenarios import read_network

    with jax.enable_x64(True):
        return told(config, build(config, read_network(path / "game.json", config.variant)))
