"""Making an environment: of an experiment with any settings, or of a run."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsiirl.errors import InputError
from gsiirl.pettingzoo.stage import Stage, stage, stage_of_run
from gsiirl.program.command import installing
from gsiirl.runs import RunFolder

if TYPE_CHECKING:
    from gsiirl.pettingzoo.environment import GameEnv


def parallel_env(experiment: str, **settings: Any) -> "GameEnv":
    """The game of `security`, `crossing` or `deception` as a PettingZoo environment.

    `settings` are those of `gsiirl run EXPERIMENT`, as keywords: `graph="small-linear"`, `horizon=20`. Those that only
    decide how somebody learns change nothing here.

    Raises:
        InputError: PettingZoo is not installed, there is no such experiment, or a setting is unknown or cannot be.
    """
    _refuse_missing()
    return _environment(stage(experiment, settings))


def run_env(folder: str | Path) -> "GameEnv":
    """The environment of the game that a run folder of `gsiirl run` is about.

    Raises:
        InputError: PettingZoo is not installed, or the folder holds no run of such a game.
    """
    _refuse_missing()
    return _environment(stage_of_run(RunFolder.open(Path(folder))))


def _environment(made: Stage) -> "GameEnv":
    from gsiirl.pettingzoo.environment import GameEnv

    return GameEnv(made.config.experiment, made.agents, made.game, made.config.double_precision)


def _refuse_missing() -> None:
    try:
        import pettingzoo as pettingzoo
    except ModuleNotFoundError as error:
        mend = f"run {installing('pettingzoo>=1.24')}"
        raise InputError("gsiirl.pettingzoo", "pettingzoo is not installed", mend) from error
