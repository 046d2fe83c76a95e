"""Named arrays in one safetensors file."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import safetensors
import safetensors.numpy

from gsiirl.errors import InputError
from gsiirl.runs.files.atomic import write_atomically
from gsiirl.runs.files.checksum import NAME, PLACE, read_intact, sealed
from gsiirl.runs.files.json_file import FORMAT_VERSION

METADATA = "__metadata__"


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray], metadata: Mapping[str, str] | None = None) -> None:
    """Write the arrays and the metadata; the same content gives the same bytes."""
    # safetensors copies raw memory and takes it for row-major, so any other order would come back scrambled.
    in_order = {name: np.asarray(array, order="C") for name, array in arrays.items()}
    content = safetensors.numpy.save(in_order, metadata={NAME: PLACE, **(metadata or {})})
    write_atomically(path, sealed(_with_sorted_metadata(content)))


def read_arrays(path: Path, mend: str, carries: bool = False) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """The arrays by name (sorted), and the metadata but for the checksum; see `read_intact` for `carries`.

    Raises:
        InputError: missing or damaged; `mend` says what to do about it.
    """
    content = read_intact(path, mend, carries)
    try:
        arrays = safetensors.numpy.load(content)
        metadata = _header(content)[0].get(METADATA, {})
    except (safetensors.SafetensorError, KeyError, ValueError) as error:
        raise InputError(str(path), f"is damaged: no valid safetensors ({str(error)[:200]})", mend) from error
    return dict(sorted(arrays.items())), {name: value for name, value in metadata.items() if name != NAME}


def read_versioned_arrays(path: Path, mend: str, carries: bool = False) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """As `read_arrays`, of a file whose metadata name the format's version.

    Raises:
        InputError: see `read_arrays`; or the file is of another version.
    """
    arrays, metadata = read_arrays(path, mend, carries)
    version = metadata.get("format_version")
    if version != str(FORMAT_VERSION):
        raise InputError(str(path), f"is damaged or of an unknown format (format_version {str(version)[:20]!r})", mend)
    return arrays, metadata


def _with_sorted_metadata(content: bytes) -> bytes:
    # safetensors writes the metadata in an order that changes from process to process.
    header, data = _header(content)
    header = {METADATA: dict(sorted(header.pop(METADATA).items())), **header}
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    text = text.ljust((len(text) + 7) // 8 * 8)
    return len(text).to_bytes(8, "little") + text + data


def _header(content: bytes) -> tuple[dict[str, dict[str, str]], bytes]:
    """The description at the begin of a safetensors file, and what follows."""
    end = 8 + int.from_bytes(content[:8], "little")
    return json.loads(content[8:end]), content[end:]
