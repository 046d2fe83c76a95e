"""Where compiled programs are kept, so that a command compiles what an earlier one has compiled no second time."""

import hashlib
import os
import platform
import warnings
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path

import platformdirs

LARGEST = 2 * 1024**3
"""Bytes that the folder may hold; what was not used for longest goes first."""
SHORTEST = 0.2
"""Seconds that a program must take to compile to be kept."""


def keep_programs() -> None:
    """Tell JAX, before it is imported, to keep compiled programs in `program_folder`, here and in child processes.

    Where the user has set `JAX_COMPILATION_CACHE_DIR` or `JAX_ENABLE_COMPILATION_CACHE`, these hold. Where the folder
    cannot be made nothing is kept.
    """
    if {"JAX_COMPILATION_CACHE_DIR", "JAX_ENABLE_COMPILATION_CACHE"} & os.environ.keys():
        return
    folder = program_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    if not os.access(folder, os.R_OK | os.W_OK | os.X_OK):
        return
    _clear_halves(folder)
    os.environ["JAX_COMPILATION_CACHE_DIR"] = str(folder)
    os.environ.setdefault("JAX_COMPILATION_CACHE_MAX_SIZE", str(LARGEST))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", str(SHORTEST))


def overlook_faults() -> None:
    """Pass over warnings that a program could not be kept or read: it is compiled then, as without the folder."""
    warnings.filterwarnings("ignore", "Error (reading|writing) persistent compilation cache entry")


def _clear_halves(folder: Path) -> None:
    """Remove the programs that a killed process or a full disk left unfinished.

    JAX writes a program, then beside it when it was used. A program without the second can be cut short, which JAX
    finds at every use and never mends; and until it is used JAX keeps no other.
    """
    names = set(os.listdir(folder))
    halves = [name for name in names if name.endswith("-cache") and f"{name.removesuffix('-cache')}-atime" not in names]
    if not halves:
        return
    from filelock import FileLock, Timeout

    # JAX's own lock: while it is held, some program is being written.
    with suppress(OSError, Timeout), FileLock(folder / ".lockfile", timeout=0):
        for name in halves:
            if not (folder / f"{name.removesuffix('-cache')}-atime").exists():
                (folder / name).unlink(missing_ok=True)


def program_folder(of: str = "programs") -> Path:
    """The folder for this version of JAX and this model of processor, in the user's cache folder."""
    return platformdirs.user_cache_path("gsiirl") / of / f"jaxlib-{version('jaxlib')}-{processor()}"


def processor() -> str:
    """The model of this machine's processor and what it can do, as 12 hexadecimal digits."""
    described = [platform.machine(), platform.processor()]
    listing = Path("/proc/cpuinfo")
    if listing.exists():
        # One blank line ends the first core; the others are alike. Its clock speed changes from one look to the next.
        for line in listing.read_text().split("\n\n")[0].splitlines():
            name, _, value = line.partition(":")
            if name.strip() in {"vendor_id", "cpu family", "model", "model name", "stepping", "flags", "Features"}:
                described.append(value.strip())
    return hashlib.sha256("\n".join(described).encode()).hexdigest()[:12]
