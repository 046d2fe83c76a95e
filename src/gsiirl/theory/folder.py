"""The folder of `gsiirl theory`: what may be written there, and what is in it already (no JAX)."""

from pathlib import Path

from gsiirl._version import __version__
from gsiirl.errors import InputError
from gsiirl.program.presence import is_there
from gsiirl.runs.findings import FINDINGS, Findings


def earlier_findings(out: Path, quick: bool) -> Findings | None:
    """What an earlier call of the same mode and version measured in `out`; None for a new or empty folder.

    Raises:
        InputError: `out` is no folder, or belongs to something else; nothing is touched.
    """
    try:
        # A call that was killed while it wrote its first file leaves that file's unfinished copy.
        present = {path.name for path in out.iterdir()} - {f"{FINDINGS}.aside"} if is_there(out) else set()
    except NotADirectoryError as error:
        raise InputError("--out", f"{out} is a file", "use another folder") from error
    except OSError as error:
        raise InputError("--out", f"{out} cannot be read ({error.strerror})", "use another folder") from error
    if FINDINGS not in present:
        if present:
            held = "a run" if "config.json" in present else "other files"
            raise InputError("--out", f"{out} holds {held}", "use a new or empty folder")
        return None
    earlier = Findings.read(out)
    version = earlier.environment.get("gsiirl")
    if version != __version__:
        raise InputError("--out", f"{out} holds findings of gsiirl {version}, not {__version__}", "use another folder")
    if earlier.quick != quick:
        made, asked = ("with", "without") if earlier.quick else ("without", "with")
        raise InputError("--out", f"{out} was made {made} --quick", f"use another folder for findings {asked} it")
    return earlier
