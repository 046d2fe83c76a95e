"""The commands that run an experiment. `gsiirl.cli` imports this module only when one of them is asked for."""

import inspect
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from gsiirl.experiments.config import (
    ExperimentConfig,
    choices,
    config_from_dict,
    field_schemas,
    load_config_file,
)
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.game.config import GameConfig
from gsiirl.experiments.security.config import SecurityConfig
from gsiirl.program.command import command
from gsiirl.program.metric_lines import metric_lines
from gsiirl.program.presence import is_file
from gsiirl.program.progress import nobody

Quiet = Annotated[bool, Parameter(negative="", help="Show no progress.")]
Out = Annotated[Path, Parameter(metavar="DIR", help="Run folder to make: a new or empty folder.")]
MetricsTo = Annotated[
    Path | None,
    Parameter(
        metavar="FILE", help="Also append the metrics to this file as they come, a line of JSON a row; - is the screen."
    ),
]
ConfigFile = Annotated[
    Path | None,
    Parameter(metavar="FILE", help="TOML file with any of the fields below (discount = 0.9); flags override it."),
]


def _with_field_flags(kind: type[ExperimentConfig]) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Of a command: a flag for each field of its configuration in place of its `**flags`."""

    def with_flags(command: Callable[..., int]) -> Callable[..., int]:
        signature = inspect.signature(command)
        own = [each for each in signature.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
        # What a command takes as an argument of its own is no flag too.
        taken = {each.name for each in own}
        flags = [_flag(field, schema) for field, schema in field_schemas(kind).items() if field not in taken]
        setattr(command, "__signature__", signature.replace(parameters=[*own, *flags]))  # noqa: B010 (not a declared attribute)
        return command

    return with_flags


def _flag(field: str, schema: dict[str, Any]) -> inspect.Parameter:
    """The flag of a field. Its value stays a text, to be checked together with those of the configuration file."""
    default = schema["default"]
    if schema["type"] == "boolean":
        kind: Any = bool | None if default is None else bool
    else:
        # What a shell can complete; other values are texts too, and refused in words of our own.
        names = choices(schema)
        kind, default = Literal[*names] | str | None if names else str | None, None if default is None else str(default)
    metavar = "|".join(choices(schema)) or {"integer": "INT", "number": "FLOAT"}.get(schema["type"], "TEXT")
    annotation = Annotated[kind, Parameter(help=schema["description"], metavar=metavar)]
    return inspect.Parameter(field, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


@_with_field_flags(SecurityConfig)
def security(
    *, out: Out, config: ConfigFile = None, metrics_to: MetricsTo = None, quiet: Quiet = False, **flags: Any
) -> int:
    """A defender lives with an attacker on an attack graph."""
    return _run(SecurityConfig, out, config, metrics_to, quiet, flags)


@_with_field_flags(CrossingConfig)
def crossing(
    *, out: Out, config: ConfigFile = None, metrics_to: MetricsTo = None, quiet: Quiet = False, **flags: Any
) -> int:
    """A robot crosses the way of a human."""
    return _run(CrossingConfig, out, config, metrics_to, quiet, flags)


@_with_field_flags(DeceptionConfig)
def deception(
    *, out: Out, config: ConfigFile = None, metrics_to: MetricsTo = None, quiet: Quiet = False, **flags: Any
) -> int:
    """Two agents keep an adversary from their target."""
    return _run(DeceptionConfig, out, config, metrics_to, quiet, flags)


@_with_field_flags(GameConfig)
def game(
    file: Annotated[
        str | None,
        Parameter(name="FILE", metavar="FILE", help="FILE.npz with the game's arrays, or FILE.py:NAME, a function."),
    ] = None,
    /,
    *,
    out: Out,
    config: ConfigFile = None,
    metrics_to: MetricsTo = None,
    quiet: Quiet = False,
    **flags: Any,
) -> int:
    """Your own finite game."""
    return _run(GameConfig, out, config, metrics_to, quiet, flags | ({} if file is None else {"file": file}))


def _run(
    kind: type[ExperimentConfig],
    out: Path,
    file: Path | None,
    metrics_to: Path | None,
    quiet: bool,
    flags: dict[str, Any],
) -> int:
    configuration = load_config_file(kind, file, flags)
    if isinstance(configuration, SecurityConfig):
        _say_before(configuration)
    from gsiirl.experiments import runner

    with _resumable(out), metric_lines(metrics_to) as rows_to:
        runner.run(configuration, out, nobody if quiet else None, rows_to)
    return _print_end(out)


def _say_before(config: SecurityConfig) -> None:
    """The scale of the rewards in a file, and the time of a long run."""
    from gsiirl.experiments.security.cost import warning_of

    for line in (config.scales_of_file(), warning_of(config.resolved())):
        if line is not None:
            print(f"gsiirl: {line}", file=sys.stderr)


def resume(
    folder: Annotated[Path, Parameter(name="DIR", help="Run folder.")],
    /,
    *,
    metrics_to: MetricsTo = None,
    quiet: Quiet = False,
) -> int:
    """Go on with an interrupted run."""
    from gsiirl.runs import RunFolder

    config_from_dict(RunFolder.open(folder).config, folder / "config.json")
    from gsiirl.experiments import runner

    with _resumable(folder), metric_lines(metrics_to) as rows_to:
        runner.resume(folder, nobody if quiet else None, rows_to)
    return _print_end(folder)


@contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        if not is_file(folder / "config.json"):
            raise KeyboardInterrupt("nothing was written yet") from None
        raise KeyboardInterrupt(f"go on with `{command('resume', folder)}`") from None


def _print_end(folder: Path) -> int:
    """Say where the run is and which of its seeds failed; the exit status is 1 where all did."""
    from gsiirl.runs import RunFolder

    report = command("report", folder, "--out", f"{folder}-report")
    print(f"The run is in {shlex.quote(str(folder))}; `{report}` makes its tables and figures.")
    summary = RunFolder.open(folder).summary() if RunFolder.is_at(folder) else None
    if summary is None or not summary.failed_seeds:
        return 0
    print_failed(folder, summary.failed_seeds)
    return 1 if summary.failed_seeds == summary.seeds else 0


def print_failed(folder: Path, seeds: list[int]) -> None:
    """Name the seeds that failed, and why one does."""
    why = "the learner, deployed, ends below random play, or a number is not finite"
    failed = f"failed: seed{'s'[: len(seeds) > 1]} {', '.join(map(str, seeds))}"
    print(f"gsiirl: {folder}: {failed} ({why})", file=sys.stderr)
