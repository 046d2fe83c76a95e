"""The commands that run an experiment. `gsiirl.cli` imports this module only when one of them is asked for."""

import inspect
import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from gsiirl.experiments.config import choices, config_from_dict, field_schemas, load_config_file


def _with_field_flags(command: Callable[..., None]) -> Callable[..., None]:
    """`command` with a flag for each field of its configuration in place of its `**flags`."""
    signature = inspect.signature(command)
    own = [each for each in signature.parameters.values() if each.kind is not inspect.Parameter.VAR_KEYWORD]
    flags = [_flag(field, schema) for field, schema in field_schemas().items()]
    setattr(command, "__signature__", signature.replace(parameters=[*own, *flags]))  # noqa: B010 (not a declared attribute)
    return command


def _flag(field: str, schema: dict[str, Any]) -> inspect.Parameter:
    """The flag of a field. Its value stays a text, to be checked together with those of the configuration file."""
    default = schema["default"]
    if schema["type"] == "boolean":
        kind: Any = bool | None if default is None else bool
    else:
        kind, default = str | None, None if default is None else str(default)
    metavar = "|".join(choices(schema)) or {"integer": "INT", "number": "FLOAT"}.get(schema["type"], "TEXT")
    annotation = Annotated[kind, Parameter(help=schema["description"], metavar=metavar)]
    return inspect.Parameter(field, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


@_with_field_flags
def security(
    *,
    out: Annotated[Path, Parameter(metavar="DIR", help="Run folder to make: a new or empty folder.")],
    config: Annotated[
        Path | None,
        Parameter(metavar="FILE", help="TOML file with any of the fields below (graph_seed = 3); flags override it."),
    ] = None,
    **flags: Any,
) -> None:
    """A defender lives with an attacker on an attack graph."""
    configuration = load_config_file(config, flags)
    from gsiirl.experiments import runner

    with _resumable(out):
        runner.run(configuration, out)
    _print_end(out)


def resume(folder: Annotated[Path, Parameter(name="DIR", help="Run folder.")], /) -> None:
    """Go on with an interrupted run."""
    from gsiirl.runs import RunFolder

    config_from_dict(RunFolder.open(folder).config, folder / "config.json")
    from gsiirl.experiments import runner

    with _resumable(folder):
        runner.resume(folder)
    _print_end(folder)


@contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        if not (folder / "config.json").is_file():
            raise KeyboardInterrupt("nothing was written yet") from None
        raise KeyboardInterrupt(f"go on with `gsiirl resume {shlex.quote(str(folder))}`") from None


def _print_end(folder: Path) -> None:
    name = shlex.quote(str(folder))
    print(f"The run is in {name}; `gsiirl report {name} --out REPORT` makes its tables and figures.")
