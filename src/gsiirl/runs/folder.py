"""The run folder: one experiment, one algorithm, several seeds."""

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
import polars
from polars.datatypes import DataTypeClass

from gsiirl.errors import InputError
from gsiirl.program.command import command
from gsiirl.program.presence import is_file, is_folder, is_there
from gsiirl.runs.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from gsiirl.runs.environment import Environment
from gsiirl.runs.files.atomic import ASIDE, refuse_unwritable, write_atomically
from gsiirl.runs.files.checksum import NAME, carries_checksum, is_intact
from gsiirl.runs.files.damage import START_AGAIN, refuse_damaged, refuse_unreadable
from gsiirl.runs.files.json_file import as_typed, read_json, read_versioned_json, sealed_json, versioned, write_json
from gsiirl.runs.files.numbers import is_sound
from gsiirl.runs.files.table_file import read_table, write_table
from gsiirl.runs.learned import Interval, LearnedParameters, read_learned, write_learned
from gsiirl.runs.lock import LOCK
from gsiirl.runs.metrics import append_chunk, read_chunks
from gsiirl.runs.policies import read_policies, write_policies
from gsiirl.runs.summary import Summary, refuse_other_metrics

INDEX_COLUMNS = ("seed", "trajectory", "step")
"""Columns of tables that count, however they are given."""
ENDING = ("learned.json", "learned.safetensors", "paths.parquet", "policies.safetensors", "reward_map.parquet")
"""Files that the end of a run writes before its summary, where it has them."""
UNBEGUN = {LOCK, "game.json", "game.json" + ASIDE, "config.json" + ASIDE}
"""What a run may leave that was killed before its `config.json` was there."""
A_RUN = "give the --out folder of a run"


@dataclass(frozen=True)
class RunFolder:
    """A run folder, made by `create` or found by `open`; every file in it is replaced whole or not at all."""

    path: Path
    config: dict[str, Any]
    """The experiment's configuration, complete."""
    game: dict[str, Any]
    """What a report needs to draw the game and to judge what was learned."""
    carries: bool = True
    """Whether its files carry checksums; those of earlier versions do not."""

    @classmethod
    def create(cls, path: Path, config: dict[str, Any], game: dict[str, Any]) -> Self:
        """Begin a run in a new or empty folder, or in one that a run left before it had begun.

        Raises:
            InputError: `path` is none of these, or cannot be written; nothing is left there then.
        """
        config_json = sealed_json("config.json", versioned(config))
        game_json = sealed_json("game.json", versioned(game))
        refuse_used(path, config, game)
        with refuse_unwritable("--out", path):
            made = not is_there(path)
            try:
                path.mkdir(parents=True, exist_ok=True)
                for name in UNBEGUN - {LOCK}:
                    (path / name).unlink(missing_ok=True)
                # config.json is what makes the folder a run folder, so it comes last.
                write_atomically(path / "game.json", game_json)
                write_atomically(path / "config.json", config_json)
            except BaseException:
                with suppress(OSError):
                    if not is_there(path / "config.json"):
                        (path / "game.json").unlink(missing_ok=True)
                    if made:
                        path.rmdir()
                raise
        return cls(path, _as_read(versioned(config)), _as_read(versioned(game)))

    @classmethod
    def open(cls, path: Path) -> Self:
        """An existing run.

        Raises:
            InputError: no folder, no run folder, or its description is damaged.
        """
        with refuse_unreadable(str(path), path, A_RUN):
            if not is_folder(path):
                raise InputError(str(path), "is no folder", A_RUN)
            if not is_file(path / "config.json"):
                raise InputError(str(path), "is no run folder: it holds no config.json", A_RUN)
        config = read_versioned_json(path / "config.json", START_AGAIN)
        game = read_versioned_json(path / "game.json", START_AGAIN, NAME in config)
        for name in ("experiment", "algorithm"):
            if not isinstance(config.get(name), str):
                raise InputError(str(path / "config.json"), f"is damaged: it names no {name}", START_AGAIN)
        carries = carries_checksum(config, path)
        for content in (config, game):
            content.pop(NAME, None)
        return cls(path, config, game, carries)

    @staticmethod
    def is_at(path: Path) -> bool:
        """Whether `path` looks like a run folder, sound or damaged."""
        return is_there(path / "config.json") and is_there(path / "game.json")

    @staticmethod
    def is_free(path: Path) -> bool:
        """Whether a run can begin in `path`: a folder that is empty, or holds what one left before it had begun."""
        names = {each.name for each in path.iterdir()}
        # A game.json without a checksum is a user's own.
        return names <= UNBEGUN and ("game.json" not in names or is_intact((path / "game.json").read_bytes()) is True)

    def append_metrics(self, chunk: int, columns: Mapping[str, np.ndarray]) -> None:
        """Write chunk number `chunk` of the metrics: `seed`, `iteration` and one column a metric, each of [rows]."""
        append_chunk(self.path / "metrics", chunk, columns)

    def metrics(self, chunks: int | None = None) -> polars.DataFrame:
        """Metrics of all chunks, or of the first `chunks`, sorted by seed and iteration.

        Raises:
            InputError: a chunk is missing or damaged, or the chunks are not those that the summary is of.
        """
        # Before the metrics: while the run goes on, both may come to be in between.
        summary = self.summary() if chunks is None else None
        metrics = read_chunks(self.path / "metrics", chunks, self.carries)
        if summary is not None:
            with refuse_damaged(self.path / "summary.json"):
                refuse_other_metrics(summary, metrics)
        return metrics

    def save_checkpoint(self, arrays: Mapping[str, np.ndarray], iteration: int, chunks: int) -> None:
        """Replace the checkpoint: the state after `iteration`, when `chunks` metrics chunks are complete."""
        write_checkpoint(self._checkpoint_path, arrays, iteration, chunks)

    def load_checkpoint(self) -> Checkpoint | None:
        """The newest checkpoint, or None before the first."""
        return read_checkpoint(self._checkpoint_path, self.carries)

    def save_learned(
        self,
        arrays: Mapping[str, np.ndarray],
        scales: Mapping[str, float],
        names: Mapping[str, Sequence[str]],
        seeds: Sequence[int],
        intervals: Mapping[str, Sequence[Interval | None]] = {},
    ) -> None:
        """Write the learned parameters: per name an array [seeds, features], its scale and its feature names.

        `intervals` are those of the weights, one a seed, for what has a posterior.
        """
        write_learned(self.path, arrays, scales, names, seeds, intervals)

    def load_learned(self, summary: Summary | None = None) -> LearnedParameters | None:
        """The learned parameters, or None where there are none; see `_recorded` for `summary`."""
        return read_learned(self.path, summary or self.summary(), self.carries)

    def save_policies(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Write the weights of the final policies, each of shape [seeds, ...]: `learner.layers.0.weight` and so on."""
        write_policies(self._policies_path, arrays)

    def load_policies(self) -> dict[str, np.ndarray] | None:
        """The weights of the final policies by name, or None where there are none."""
        return read_policies(self._policies_path, self.summary(), self.carries)

    def save_paths(self, columns: Mapping[str, np.ndarray]) -> None:
        """Write the sample trajectories: `seed`, `trajectory`, `step` and what was there then, each of [rows]."""
        write_table(self._paths_path, columns, _types(columns))

    def paths(self, summary: Summary | None = None) -> polars.DataFrame | None:
        """The sample trajectories, or None where there are none; see `_recorded` for `summary`."""
        return self._recorded(self._paths_path, INDEX_COLUMNS, summary or self.summary())

    def save_reward_map(self, columns: Mapping[str, np.ndarray]) -> None:
        """Write the expert's reward by position: `seed`, `x`, `y`, `learned`, `true`, each of [rows]."""
        write_table(self._reward_map_path, columns, _types(columns))

    def reward_map(self, summary: Summary | None = None) -> polars.DataFrame | None:
        """The expert's reward by position, or None where the game has none; see `_recorded` for `summary`."""
        return self._recorded(self._reward_map_path, INDEX_COLUMNS[:1], summary or self.summary())

    def _recorded(self, path: Path, counted: Sequence[str], summary: Summary | None) -> polars.DataFrame | None:
        """A table with whole numbers in the columns `counted`, the seed among them.

        `summary` says which seeds there are, and of which there must be finite numbers; it is the folder's own, or one
        that was made of the metrics of a run that has not ended.
        """
        if not is_there(path):
            return None
        table = read_table(path, START_AGAIN, self.carries)
        wrong = [name for name in counted if table.schema.get(name) != polars.Int64]
        wrong += [name for name, kind in table.schema.items() if kind not in (polars.Int64, polars.Float64)]
        if wrong:
            raise InputError(str(path), f"is damaged: column {wrong[0]} is missing or of another type", START_AGAIN)
        if summary is not None:
            if not {*table["seed"]} <= {*summary.seeds}:
                raise InputError(str(path), "is damaged: it is not of the seeds of summary.json", START_AGAIN)
            kept = table.filter(polars.col("seed").is_in(summary.kept_seeds))
            if not all(is_sound(column.to_numpy()).all() for column in kept.drop(counted)):
                raise InputError(str(path), "is damaged: it holds what is no number", START_AGAIN)
        return table

    def write_summary(self, summary: Summary) -> None:
        """Write `summary.json` (see `summarise`), which names the other files of the run's end."""
        files = [name for name in ENDING if is_there(self.path / name)]
        write_json(self.path / "summary.json", versioned(asdict(replace(summary, files=files))))

    def summary(self) -> Summary | None:
        """The summary, or None where the run has not ended.

        Raises:
            InputError: it is damaged, of another run, or names a file that is missing.
        """
        path = self.path / "summary.json"
        if not is_there(path):
            return None
        summary = as_typed(Summary, read_versioned_json(path, START_AGAIN, self.carries), path, START_AGAIN)
        if (summary.experiment, summary.algorithm) != (self.config["experiment"], self.config["algorithm"]):
            raise InputError(str(path), "is damaged: it is of another run", START_AGAIN)
        if not {*summary.files} <= {*ENDING}:
            raise InputError(str(path), "is damaged: it names files that no run writes", START_AGAIN)
        for name in summary.files:
            if not is_there(self.path / name):
                raise InputError(str(self.path / name), "is missing", START_AGAIN)
        return summary

    def is_finished(self) -> bool:
        """Whether the run has ended, so that there is nothing to go on with."""
        summary = self.summary()
        return summary is not None and summary.completed

    def write_evaluation(self, simulator: str, evaluation: dict[str, Any]) -> None:
        """Write `evaluation-SIMULATOR.json`: what the final policies earn in another implementation of the game."""
        write_json(self.path / f"evaluation-{simulator}.json", versioned(evaluation))

    def write_transfer(self, transfer: dict[str, Any]) -> None:
        """Write `transfer.json`: what the learned rewards are worth in changed games."""
        write_json(self.path / "transfer.json", versioned(transfer))

    def write_environment(self, environment: Environment) -> None:
        """Write `environment.json`: versions, device, wall times."""
        write_json(self.path / "environment.json", asdict(environment))

    def environment(self) -> Environment | None:
        """Where and how long the run ran, or None where it was not written."""
        path = self.path / "environment.json"
        if not is_there(path):
            return None
        return as_typed(Environment, read_json(path, START_AGAIN, self.carries), path, START_AGAIN)

    @property
    def _checkpoint_path(self) -> Path:
        return self.path / "checkpoint" / "state.safetensors"

    @property
    def _policies_path(self) -> Path:
        return self.path / "policies.safetensors"

    @property
    def _paths_path(self) -> Path:
        return self.path / "paths.parquet"

    @property
    def _reward_map_path(self) -> Path:
        return self.path / "reward_map.parquet"


def _types(columns: Mapping[str, np.ndarray]) -> dict[str, DataTypeClass]:
    counted = {name for name, column in columns.items() if np.asarray(column).dtype.kind in "biu"}
    return {name: polars.Int64 if name in {*INDEX_COLUMNS, *counted} else polars.Float64 for name in columns}


def refuse_used(path: Path, config: dict[str, Any], game: dict[str, Any] | None = None) -> None:
    """See that a run of this configuration and game (of any, if None) can begin in `path`; nothing is touched.

    Raises:
        InputError: it is a file, or a folder with other files or a run, be it this one.
    """
    field, mend = "--out", "use another folder"
    with refuse_unreadable(field, path, mend):
        if not is_there(path):
            return
        if not is_folder(path):
            raise InputError(field, f"{path} is a file", mend)
        if RunFolder.is_free(path):
            return
        if not is_there(path / "config.json"):
            raise InputError(field, f"{path} holds other files", "use a new or empty folder")
    try:
        present = RunFolder.open(path)
    except InputError as error:
        raise InputError(field, f"{path} holds other files or a damaged run", "use a new or empty folder") from error
    other_game = game is not None and present.game != _as_read(versioned(game))
    if present.config != _as_read(versioned(config)) or other_game:
        raise InputError(field, f"{path} holds another run", mend)
    if game is not None:
        resume = command("resume", path)
        raise InputError(field, f"{path} holds this run already", f"use {resume} or another folder")


def _as_read(content: dict[str, Any]) -> dict[str, Any]:
    """As it would be read back, so that tuples and lists compare equal."""
    return json.loads(json.dumps(content))
