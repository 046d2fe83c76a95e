"""A sweep: every combination of the values that a file gives for the fields of an experiment.

    experiment = "security"
    graph = "small-linear"
    algorithm = ["gsiirl", "ma-irl"]      # a list: one run for each
    temperature = [0.4, 0.1]
    seeds = 10

is four runs. A file may hold several such tables, each below a line `[[grid]]`.
"""

import itertools
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gsiirl.errors import InputError
from gsiirl.experiments.config import EXPERIMENTS, ExperimentConfig, load_config
from gsiirl.experiments.plans.planned_run import PlannedRun

GRID, EXPERIMENT = "grid", "experiment"
MOST_RUNS = 10_000


def read_sweep(file: Path, out: Path) -> list[PlannedRun]:
    """The runs of a sweep's file, each in a folder of its own below `out`.

    A folder is named after the fields that differ: `algorithm=gsiirl,temperature=0.4`.

    Raises:
        InputError: the file cannot be read, names what no experiment has, or the same run twice.
    """
    grids = _grids(file)
    # A list of one value is part of the name too: a value more later leaves the names of the runs as they are.
    listed = {field for grid in grids for field, value in grid.items() if isinstance(value, list)}
    given = list(dict.fromkeys(field for grid in grids for field in grid))
    absent = object()
    named = [
        each
        for each in given
        if each in listed or any(g.get(each, absent) != grids[0].get(each, absent) for g in grids)
    ]
    planned: dict[str, ExperimentConfig] = {}
    for values, config in _configs(grids, file):
        name = ",".join(f"{field}={_word(values[field])}" for field in named if field in values)
        name = name or str(values[EXPERIMENT])
        if name in planned:
            raise InputError(str(file), f"has two runs {name}", "give every run another value of some field")
        planned[name] = config
    return [PlannedRun(out / name, config) for name, config in planned.items()]


def part_of(planned: list[PlannedRun], part: str | None) -> list[PlannedRun]:
    """The share `K/N` of a plan: every Nth run, from the Kth on. All of it where none is asked for.

    Raises:
        InputError: it is no such share.
    """
    if part is None:
        return planned
    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", part)
    number, parts = map(int, found.groups()) if found else (0, 0)
    if not 1 <= number <= parts:
        raise InputError(
            "--part", f"cannot be {part[:40] or 'empty'}", "give it as K/N, such as 1/8 for the first of eight"
        )
    return planned[number - 1 :: parts]


def _grids(file: Path) -> list[dict[str, Any]]:
    try:
        content = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(str(file), f"cannot be read ({error.strerror})", "give a TOML file") from error
    except (ValueError, RecursionError) as error:
        raise InputError(str(file), f"is not TOML ({error})", "mend the file") from error
    listed = content.pop(GRID, [])
    if not isinstance(listed, list) or not all(isinstance(each, dict) for each in listed):
        raise InputError(f"{GRID} in {file}", "is no list of tables", f"write [[{GRID}]] above each table")
    # What stands above the first table holds for all of them.
    grids = [content | grid for grid in listed] if listed else [content]
    for grid in grids:
        for field, value in grid.items():
            if value == [] or isinstance(value, dict):
                mend = "give a value, or a list of at least one"
                raise InputError(f"{field} in {file}", f"cannot be {value!r:.60}", mend)
    return grids


def _configs(grids: list[dict[str, Any]], file: Path) -> Iterator[tuple[Mapping[str, Any], ExperimentConfig]]:
    """Every combination, with its configuration."""
    if sum(math.prod(len(_several(value)) for value in grid.values()) for grid in grids) > MOST_RUNS:
        raise InputError(str(file), f"has more than {MOST_RUNS:,} runs", "give fewer values")
    for grid in grids:
        fields = [field for field in grid if field != EXPERIMENT]
        experiments = _several(grid.get(EXPERIMENT))
        for experiment in experiments:
            if not isinstance(experiment, str) or experiment not in EXPERIMENTS:
                problem = "is missing" if experiment is None else f"cannot be {experiment!r:.60}"
                raise InputError(f"{EXPERIMENT} in {file}", problem, f"choose from {', '.join(EXPERIMENTS)}")
        for experiment, *chosen in itertools.product(experiments, *(_several(grid[field]) for field in fields)):
            values = dict(zip(fields, chosen, strict=True))
            config = load_config(EXPERIMENTS[experiment], values, lambda field: f"{field} in {file}")
            yield {EXPERIMENT: experiment, **values}, config


def _several(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _word(value: Any) -> str:
    """A value in a folder's name: of a path its last part, and nothing that a shell or a file system minds."""
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return re.sub(r"[^\w.+-]+", "_", Path(text).name if "/" in text else text)
