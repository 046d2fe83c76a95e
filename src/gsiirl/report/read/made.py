"""How a run was made: the command, its settings, the version and the date."""

import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from gsiirl.runs import Environment, RunFolder

NOT_RECORDED = "not recorded"
OF_A_RANDOM_GRAPH = ("graph_seed", "nodes", "edges")
"""Settings that say nothing where a network is named."""
NO_SETTINGS = ("format_version", "experiment", "file")


@dataclass(frozen=True)
class Made:
    """What is needed to make a run again; no path of the machine that it was made on."""

    version: str
    """Of gsiirl."""
    date: str
    """On which it ended, or was last written: 2026-01-31, in universal time."""
    seeds: str
    command: str
    settings: dict[str, str]
    """All of them, by name."""

    @classmethod
    def of(cls, folder: RunFolder, environment: Environment | None, seeds: list[int]) -> "Made":
        """How the run in a folder was made."""
        finished = "" if environment is None else environment.finished
        return cls(
            version=(environment.gsiirl if environment is not None else "") or NOT_RECORDED,
            date=finished[:10] or _last_written(folder.path),
            seeds=_seeds(seeds),
            command=_command(folder.config, folder.path.name),
            settings={name: _shown(value) for name, value in _settings(folder.config).items()},
        )


@dataclass(frozen=True)
class MadeGroup:
    """How the runs of one game were made."""

    title: str
    """The game's; empty where the page has one game."""
    runs: dict[str, Made]
    """By label."""

    @property
    def settings(self) -> list[str]:
        """Names of all settings of the runs."""
        return list(dict.fromkeys(name for run in self.runs.values() for name in run.settings))


def _settings(config: Mapping[str, Any]) -> dict[str, Any]:
    """What was set, whether by the user or by default."""
    left_out = (*NO_SETTINGS, *(OF_A_RANDOM_GRAPH if config.get("graph") else ()))
    return {name: value for name, value in config.items() if value is not None and name not in left_out}


def _command(config: Mapping[str, Any], folder: str) -> str:
    """The command that makes the run again, with every setting."""
    words = ["gsiirl", "run", str(config["experiment"])]
    if "file" in config:
        words.append(_shown(config["file"]))
    for name, value in _settings(config).items():
        flag = name.replace("_", "-")
        words += [f"--{'' if value else 'no-'}{flag}"] if isinstance(value, bool) else [f"--{flag}", _shown(value)]
    return shlex.join([*words, "--out", folder])


def _shown(value: Any) -> str:
    """A setting as text; of a path its last part alone."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return re.split(r"[\\/]", value)[-1] if isinstance(value, str) else str(value)


def _seeds(seeds: list[int]) -> str:
    """`0 to 9`, or all of them where some between are missing."""
    if len(seeds) > 2 and seeds == list(range(seeds[0], seeds[-1] + 1)):
        return f"{seeds[0]} to {seeds[-1]}"
    return ", ".join(map(str, seeds))


def _last_written(folder: Path) -> str:
    """The date of the newest metrics, for a run that has not ended."""
    newest = max((path.stat().st_mtime for path in (folder / "metrics").glob("chunk-*.parquet")), default=None)
    return NOT_RECORDED if newest is None else datetime.fromtimestamp(newest, UTC).date().isoformat()
