"""Reading a configuration: from flags and a TOML file, or back from a run's `config.json`."""

import difflib
import functools
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import asdict, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from gsiirl.errors import InputError
from gsiirl.experiments.crossing.config import CrossingConfig
from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.game.config import GameConfig
from gsiirl.experiments.security.config import SecurityConfig

ExperimentConfig = SecurityConfig | CrossingConfig | DeceptionConfig | GameConfig
Config = TypeVar("Config", bound=ExperimentConfig)

EXPERIMENTS: dict[str, type[ExperimentConfig]] = {
    kind.experiment: kind for kind in (SecurityConfig, CrossingConfig, DeceptionConfig, GameConfig)
}


def flag(field: str) -> str:
    """The flag of a field: `graph_seed` is `--graph-seed`."""
    return "--" + field.replace("_", "-")


@functools.cache
def field_schemas(kind: type[ExperimentConfig]) -> Mapping[str, dict[str, Any]]:
    """Of each field its JSON schema, in order: `description`, `default`, and the values it accepts when it is set."""
    descriptions: dict[str, str] = {}
    # Pydantic takes the text below a field for its description only in the class that declares the field.
    for declaring in reversed([each for each in kind.__mro__ if is_dataclass(each)]):
        schemas = TypeAdapter[Any](declaring).json_schema()["properties"]
        descriptions |= {name: each["description"] for name, each in schemas.items() if "description" in each}
    schemas = TypeAdapter(kind).json_schema()["properties"]
    return {
        field.name: schemas[field.name] | _when_set(schemas[field.name]) | {"description": descriptions[field.name]}
        for field in fields(kind)
    }


def choices(schema: Mapping[str, Any]) -> list[str]:
    """The names that a field chooses from, or none where it does not."""
    return [schema["const"]] if "const" in schema else schema.get("enum", [])


def load_config(kind: type[Config], values: Mapping[str, Any], name: Callable[[str], str] = str) -> Config:
    """The configuration with these fields set and the others at their defaults.

    `name` gives the name by which the user knows a field, for errors.

    Raises:
        InputError: for the first unknown field, or else the first value that its field does not accept.
    """
    schemas = field_schemas(kind)
    for field in values:
        if field not in schemas:
            near = difflib.get_close_matches(field, schemas, n=1)
            mend = f"did you mean {near[0]}?" if near else f"the fields are {', '.join(schemas)}"
            raise InputError(name(field), f"is no field of the {kind.experiment} experiment", mend)
    try:
        return kind(**values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        field, value = str(first["loc"][0]), first["input"]
        shown = value if isinstance(value, str) and value.strip() else repr(value)
        raise InputError(name(field), f"cannot be {_shortened(shown)}", _accepted(schemas[field])) from error


def load_config_file(kind: type[Config], path: Path | None, flags: Mapping[str, Any]) -> Config:
    """The configuration of a TOML file whose keys are fields (or of none), with `flags` in place of what it says.

    Raises:
        InputError: see `load_config`; or the file cannot be read, or is not TOML.
    """
    written = {} if path is None else _read_toml(path)
    return load_config(
        kind, {**written, **flags}, lambda field: flag(field) if field in flags else f"{field} in {path}"
    )


def config_to_dict(config: ExperimentConfig) -> dict[str, Any]:
    """What `config.json` holds besides its format's version: the experiment and every field."""
    return {"experiment": config.experiment, **asdict(config)}


def config_from_dict(content: Mapping[str, Any], source: Path) -> ExperimentConfig:
    """The configuration in the content of a `config.json`; `source` is its path, for errors.

    Raises:
        InputError: see `load_config`; or the file is of an experiment that is not known.
    """
    values = {name: value for name, value in content.items() if name != "format_version"}
    experiment = values.pop("experiment", None)
    if experiment not in EXPERIMENTS:
        mend = f"this version of gsiirl knows {', '.join(EXPERIMENTS)}"
        raise InputError(f"experiment in {source}", f"cannot be {experiment!r}", mend)
    return load_config(EXPERIMENTS[experiment], values, lambda field: f"{field} in {source}")


def _read_toml(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError("--config", f"{path} cannot be read ({error.strerror})", "give a TOML file") from error
    except (ValueError, RecursionError) as error:
        raise InputError("--config", f"{path} is not TOML ({error})", "mend the file") from error


def _when_set(schema: dict[str, Any]) -> dict[str, Any]:
    """A schema without the null that an optional field also accepts; a word in place of a number is its `word`."""
    alternatives = [each for each in schema.get("anyOf", [schema]) if each.get("type") != "null"]
    words = [each["const"] for each in alternatives[1:] if "const" in each]
    return alternatives[0] | ({"word": words[0]} if words else {})


def _accepted(schema: Mapping[str, Any]) -> str:
    """The mend that a field's schema amounts to."""
    if names := choices(schema):
        return f"choose {' or '.join(names)}"
    kinds = {"boolean": "true or false", "string": "a text", "integer": "a whole number", "number": "a number"}
    limits = {"minimum": "of at least", "exclusiveMinimum": "above", "maximum": "at most"}
    bounds = [f"{words} {schema[key]}" for key, words in limits.items() if key in schema]
    word = f", or {schema['word']}" if "word" in schema else ""
    return " ".join(["give", kinds[schema["type"]], " and ".join(bounds)]).rstrip() + word


def at_least_one(name: str, text: str, most: int) -> int:
    """The whole number that a flag is given; see `whole`."""
    return whole(name, text, 1, most)


def whole(name: str, text: str, least: int, most: int) -> int:
    """The whole number that a flag is given.

    Raises:
        InputError: it is none, below `least`, or above `most`.
    """
    # A number of too many digits is not even read.
    if not text.isdecimal() or len(text) > 20 or not least <= int(text) <= most:
        problem, mend = (
            f"cannot be {_shortened(text) or 'empty'}",
            f"give a whole number of at least {least} and at most {most}",
        )
        raise InputError(name, problem, mend)
    return int(text)


def _shortened(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:40]}... ({len(text)} characters)"
