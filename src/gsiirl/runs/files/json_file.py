"""JSON files of a run folder: fixed key order, exact floats, no NaN, a checksum."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

from gsiirl.errors import InputError
from gsiirl.runs.files.atomic import write_atomically
from gsiirl.runs.files.checksum import NAME, PLACE, is_checksum, read_intact, sealed
from gsiirl.runs.files.numbers import LARGEST

FORMAT_VERSION = 1
"""The layout of run folders that this version writes and reads."""

Kind = TypeVar("Kind")


def encode_json(name: str, content: dict[str, Any]) -> bytes:
    """`content` in the order of its keys, floats as `repr` (so that they read back bit for bit); `name` is for errors.

    Raises:
        ValueError: a number is NaN or infinite.
    """
    for place, number in _numbers(content, ""):
        if not math.isfinite(number):
            raise ValueError(f"{name}: {place} is {number}; a run folder's JSON holds finite numbers only")
    return (json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def sealed_json(name: str, content: dict[str, Any]) -> bytes:
    """`content` as `encode_json` gives it, after its checksum."""
    return sealed(encode_json(name, {NAME: PLACE, **content}))


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write `content` as `sealed_json` gives it; if that fails, nothing is written."""
    write_atomically(path, sealed_json(path.name, content))


def versioned(content: dict[str, Any]) -> dict[str, Any]:
    """`content` with its `format_version` first."""
    return {"format_version": FORMAT_VERSION, **content}


def read_json(path: Path, mend: str, carries: bool = False) -> dict[str, Any]:
    """The object in `path`; see `read_intact` for `carries`.

    Raises:
        InputError: unreadable, damaged, not valid JSON, no object, or a number in it is not finite; `mend`
            says what to do about it.
    """
    from pydantic_core import from_json

    try:
        content = from_json(read_intact(path, mend, carries), allow_inf_nan=False)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(str(path), f"is damaged: no valid JSON ({error})", mend) from error
    if not isinstance(content, dict):
        raise InputError(str(path), "is damaged: no JSON object", mend)
    for place, number in _numbers(content, ""):
        if abs(number) > LARGEST:
            raise InputError(str(path), f"is damaged: {_short(place)} is no number of a sensible size", mend)
    if NAME in content and not is_checksum(content[NAME]):
        raise InputError(str(path), "is damaged: its checksum is gone", mend)
    return content


def read_versioned_json(path: Path, mend: str, carries: bool = False) -> dict[str, Any]:
    """As `read_json`, for a file whose `format_version` must be the one known here."""
    content = read_json(path, mend, carries)
    version = content.get("format_version")
    if version is None:
        raise InputError(str(path), "is damaged: it names no format_version", mend)
    if version != FORMAT_VERSION or isinstance(version, bool):
        raise InputError(
            str(path),
            f"unknown format_version {_short(repr(version))}",
            f"this version of gsiirl reads format_version {FORMAT_VERSION}: use the version that wrote the run",
        )
    return content


def as_typed(kind: type[Kind], content: dict[str, Any], path: Path, mend: str) -> Kind:
    """The dataclass `kind` from the object that `path` holds: every field there, and of its own type.

    What a dataclass asks of its values together it says by a `ValueError` from `__post_init__`. Other keys are ignored.

    Raises:
        InputError: a field is missing or wrong; `mend` says what to do about it.
    """
    from pydantic import TypeAdapter, ValidationError

    try:
        # As JSON, because of Python's own objects pydantic would want instances of the dataclass.
        return TypeAdapter(kind).validate_json(json.dumps(content), strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place, problem = ".".join(map(str, first["loc"])), first["msg"].removeprefix("Value error, ")
        words = ": ".join(filter(None, ["is damaged", _short(place), problem]))
        raise InputError(str(path), words, mend) from error


def _short(text: str) -> str:
    return text if len(text) <= 100 else f"{text[:100]}..."


def _numbers(content: Any, place: str) -> Iterator[tuple[str, float]]:
    if isinstance(content, dict):
        for key, value in content.items():
            yield from _numbers(value, f"{place}.{key}" if place else str(key))
    elif isinstance(content, list | tuple):
        for index, value in enumerate(content):
            yield from _numbers(value, f"{place}[{index}]")
    elif isinstance(content, int | float):
        yield place, content
