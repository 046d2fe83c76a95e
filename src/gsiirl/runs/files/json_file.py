"""JSON files of a run folder: fixed key order, exact floats, no NaN."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

from gsiirl.errors import InputError
from gsiirl.runs.files.atomic import write_atomically

FORMAT_VERSION = 1
"""The layout of run folders that this version writes and reads."""


def encode_json(name: str, content: dict[str, Any]) -> bytes:
    """`content` in the order of its keys, floats as `repr` (so that they read back bit for bit); `name` is for errors.

    Raises:
        ValueError: a number is NaN or infinite.
    """
    for place, number in _numbers(content, ""):
        if not math.isfinite(number):
            raise ValueError(f"{name}: {place} is {number}; a run folder's JSON holds finite numbers only")
    return (json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write `content` as `encode_json` gives it; if that fails, nothing is written."""
    write_atomically(path, encode_json(path.name, content))


def versioned(content: dict[str, Any]) -> dict[str, Any]:
    """`content` with its `format_version` first."""
    return {"format_version": FORMAT_VERSION, **content}


def read_json(path: Path, mend: str) -> dict[str, Any]:
    """The object in `path`.

    Raises:
        InputError: unreadable, not valid JSON, or no object; `mend` says what to do about it.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse_constant)
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error.strerror})", mend) from error
    except ValueError as error:
        raise InputError(str(path), f"is damaged: no valid JSON ({error})", mend) from error
    if not isinstance(content, dict):
        raise InputError(str(path), "is damaged: no JSON object", mend)
    return content


def read_versioned_json(path: Path, mend: str) -> dict[str, Any]:
    """As `read_json`, for a file whose `format_version` must be the one known here."""
    content = read_json(path, mend)
    version = content.get("format_version")
    if version is None:
        raise InputError(str(path), "is damaged: it names no format_version", mend)
    if version != FORMAT_VERSION:
        raise InputError(
            str(path),
            f"unknown format_version {version!r}",
            f"this version of gsiirl reads format_version {FORMAT_VERSION}: use the version that wrote the run",
        )
    return content


def _numbers(content: Any, place: str) -> Iterator[tuple[str, float]]:
    if isinstance(content, dict):
        for key, value in content.items():
            yield from _numbers(value, f"{place}.{key}" if place else str(key))
    elif isinstance(content, list | tuple):
        for index, value in enumerate(content):
            yield from _numbers(value, f"{place}[{index}]")
    elif isinstance(content, float):
        yield place, content


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no JSON number")
