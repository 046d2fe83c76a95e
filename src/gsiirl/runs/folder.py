"""The run folder: one experiment, one algorithm, several seeds."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import polars
from polars.datatypes import DataTypeClass

from gsiirl.errors import InputError
from gsiirl.runs.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from gsiirl.runs.files.atomic import write_atomically
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.files.json_file import encode_json, read_json, read_versioned_json, versioned, write_json
from gsiirl.runs.files.table_file import read_table, write_table
from gsiirl.runs.learned import LearnedParameters, read_learned, write_learned
from gsiirl.runs.metrics import append_chunk, read_chunks
from gsiirl.runs.policies import read_policies, write_policies

INDEX_COLUMNS = ("seed", "trajectory", "step")
"""Columns of tables that count, however they are given."""


@dataclass(frozen=True)
class RunFolder:
    """A run folder, made by `create` or found by `open`; every file in it is replaced whole or not at all."""

    path: Path
    config: dict[str, Any]
    """The experiment's configuration, complete."""
    game: dict[str, Any]
    """What a report needs to draw the game and to judge what was learned."""

    @classmethod
    def create(cls, path: Path, config: dict[str, Any], game: dict[str, Any]) -> Self:
        """Begin a run in a new or empty folder.

        Raises:
            InputError: `path` is not a new or empty folder, or cannot be made; nothing is touched.
        """
        config_json = encode_json("config.json", versioned(config))
        game_json = encode_json("game.json", versioned(game))
        # As they would be read back, so that tuples and lists compare equal.
        config, game = json.loads(config_json), json.loads(game_json)
        _refuse_used(path, config, game)
        try:
            path.mkdir(parents=True, exist_ok=True)
            # config.json is what makes the folder a run folder, so it comes last.
            write_atomically(path / "game.json", game_json)
            write_atomically(path / "config.json", config_json)
        except OSError as error:
            raise InputError("--out", f"{path} cannot be written ({error.strerror})", "use another folder") from error
        return cls(path, config, game)

    @classmethod
    def open(cls, path: Path) -> Self:
        """An existing run.

        Raises:
            InputError: no folder, no run folder, or its description is damaged.
        """
        if not path.is_dir():
            raise InputError(str(path), "is no folder", "give the --out folder of a run")
        if not (path / "config.json").is_file():
            raise InputError(str(path), "is no run folder: it holds no config.json", "give the --out folder of a run")
        config, game = (read_versioned_json(path / name, START_AGAIN) for name in ("config.json", "game.json"))
        for name in ("experiment", "algorithm"):
            if not isinstance(config.get(name), str):
                raise InputError(str(path / "config.json"), f"is damaged: it names no {name}", START_AGAIN)
        return cls(path, config, game)

    @staticmethod
    def is_at(path: Path) -> bool:
        """Whether `path` looks like a run folder, sound or damaged."""
        return (path / "config.json").exists() and (path / "game.json").exists()

    def append_metrics(self, chunk: int, columns: Mapping[str, np.ndarray]) -> None:
        """Write chunk number `chunk` of the metrics: `seed`, `iteration` and one column a metric, each of [rows]."""
        append_chunk(self.path / "metrics", chunk, columns)

    def metrics(self, chunks: int | None = None) -> polars.DataFrame:
        """Metrics of all chunks, or of the first `chunks`, sorted by seed and iteration."""
        return read_chunks(self.path / "metrics", chunks)

    def save_checkpoint(self, arrays: Mapping[str, np.ndarray], iteration: int, chunks: int) -> None:
        """Replace the checkpoint: the state after `iteration`, when `chunks` metrics chunks are complete."""
        write_checkpoint(self._checkpoint_path, arrays, iteration, chunks)

    def load_checkpoint(self) -> Checkpoint | None:
        """The newest checkpoint, or None before the first."""
        return read_checkpoint(self._checkpoint_path)

    def save_learned(
        self,
        arrays: Mapping[str, np.ndarray],
        scales: Mapping[str, float],
        names: Mapping[str, Sequence[str]],
        seeds: Sequence[int],
    ) -> None:
        """Write the learned parameters: per name an array [seeds, features], its scale and its feature names."""
        write_learned(self.path, arrays, scales, names, seeds)

    def load_learned(self) -> LearnedParameters | None:
        """The learned parameters, or None where there are none."""
        return read_learned(self.path)

    def save_policies(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Write the weights of the final policies, each of shape [seeds, ...]: `learner.layers.0.weight` and so on."""
        write_policies(self._policies_path, arrays)

    def load_policies(self) -> dict[str, np.ndarray] | None:
        """The weights of the final policies by name, or None where there are none."""
        return read_policies(self._policies_path)

    def save_paths(self, columns: Mapping[str, np.ndarray]) -> None:
        """Write the sample trajectories: `seed`, `trajectory`, `step` and what was there then, each of [rows]."""
        write_table(self._paths_path, columns, _types(columns))

    def paths(self) -> polars.DataFrame | None:
        """The sample trajectories, or None where there are none."""
        return read_table(self._paths_path, START_AGAIN) if self._paths_path.exists() else None

    def save_reward_map(self, columns: Mapping[str, np.ndarray]) -> None:
        """Write the expert's reward by position: `seed`, `x`, `y`, `learned`, `true`, each of [rows]."""
        write_table(self._reward_map_path, columns, _types(columns))

    def reward_map(self) -> polars.DataFrame | None:
        """The expert's reward by position, or None where the game has none."""
        return read_table(self._reward_map_path, START_AGAIN) if self._reward_map_path.exists() else None

    def write_summary(self, summary: dict[str, Any]) -> None:
        """Write `summary.json` (see `summarise`)."""
        write_json(self.path / "summary.json", versioned(summary))

    def summary(self) -> dict[str, Any] | None:
        """The summary, or None where the run has not ended."""
        path = self.path / "summary.json"
        return read_versioned_json(path, START_AGAIN) if path.exists() else None

    def is_finished(self) -> bool:
        """Whether the run has ended, so that there is nothing to go on with."""
        summary = self.summary()
        return summary is not None and summary["completed"]

    def write_evaluation(self, simulator: str, evaluation: dict[str, Any]) -> None:
        """Write `evaluation-SIMULATOR.json`: what the final policies earn in another implementation of the game."""
        write_json(self.path / f"evaluation-{simulator}.json", versioned(evaluation))

    def write_environment(self, environment: dict[str, Any]) -> None:
        """Write `environment.json`: versions, device, wall times."""
        write_json(self.path / "environment.json", environment)

    def environment(self) -> dict[str, Any] | None:
        """Where and how long the run ran, or None where it was not written."""
        path = self.path / "environment.json"
        return read_json(path, START_AGAIN) if path.exists() else None

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


def _refuse_used(path: Path, config: dict[str, Any], game: dict[str, Any]) -> None:
    field = "--out"
    if not path.exists():
        return
    if not path.is_dir():
        raise InputError(field, f"{path} is a file", "use another folder")
    try:
        empty = not any(path.iterdir())
    except OSError as error:
        raise InputError(field, f"{path} cannot be read ({error.strerror})", "use another folder") from error
    if empty:
        return
    if not (path / "config.json").exists():
        raise InputError(field, f"{path} holds other files", "use a new or empty folder")
    try:
        present = RunFolder.open(path)
    except InputError as error:
        raise InputError(field, f"{path} holds other files or a damaged run", "use a new or empty folder") from error
    if (present.config, present.game) == (config, game):
        raise InputError(field, f"{path} holds this run already", f"use gsiirl resume {path} or another folder")
    raise InputError(field, f"{path} holds another run", "use another folder")
