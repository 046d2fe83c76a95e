"""Named arrays in one safetensors file."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import safetensors
import safetensors.numpy

from gsiirl.errors import InputError
from gsiirl.runs.files.atomic import write_atomically
from gsiirl.runs.files.json_file import FORMAT_VERSION


def write_arrays(path: Path, arrays: Mapping[str, np.ndarray], metadata: Mapping[str, str] | None = None) -> None:
    """Write the arrays and the metadata; the same content gives the same bytes."""
    # safetensors copies raw memory and takes it for row-major, so any other order would come back scrambled.
    in_order = {name: np.asarray(array, order="C") for name, array in arrays.items()}
    content = safetensors.numpy.save(in_order, metadata=dict(metadata) if metadata else None)
    write_atomically(path, _with_sorted_metadata(content))


def read_arrays(path: Path, mend: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """The arrays by name (sorted), and the metadata.

    Raises:
        InputError: missing or damaged; `mend` says what to do about it.
    """
    try:
        with safetensors.safe_open(path, framework="numpy") as file:
            arrays = {name: file.get_tensor(name) for name in sorted(file.keys())}
            return arrays, file.metadata() or {}
    except OSError as error:
        raise InputError(str(path), f"cannot be read ({error})", mend) from error
    except safetensors.SafetensorError as error:
        raise InputError(str(path), f"is damaged: no valid safetensors ({error})", mend) from error


def read_versioned_arrays(path: Path, mend: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """As `read_arrays`, of a file whose metadata name the format's version.

    Raises:
        InputError: see `read_arrays`; or the file is of another version.
    """
    arrays, metadata = read_arrays(path, mend)
    version = metadata.get("format_version")
    if version != str(FORMAT_VERSION):
        raise InputError(str(path), f"is damaged or of an unknown format (format_version {version!r})", mend)
    return arrays, metadata


def _with_sorted_metadata(content: bytes) -> bytes:
    # safetensors writes the metadata in an order that changes from process to process.
    length = int.from_bytes(content[:8], "little")
    header = json.loads(content[8 : 8 + length])
    if "__metadata__" not in header:
        return content
    header["__metadata__"] = dict(sorted(header["__metadata__"].items()))
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode()
    text = text.ljust((len(text) + 7) // 8 * 8)
    return len(text).to_bytes(8, "little") + text + content[8 + length :]
