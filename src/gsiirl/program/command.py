"""Commands to show to the user, which work as they stand when they are pasted into the same terminal."""

import importlib.util
import shlex
import shutil
import sys
from pathlib import Path


def command(*words: object) -> str:
    """A command of this program: `gsiirl resume 'my run'`, or `.venv/bin/gsiirl ...` where it was called so."""
    return " ".join([_program(), *(shlex.quote(str(word)) for word in words)])


def installing(requirement: str) -> str:
    """A command that installs a package beside this program."""
    python = shlex.quote(sys.executable)
    how = f"{python} -m pip install" if importlib.util.find_spec("pip") else f"uv pip install --python {python}"
    return f"{how} {shlex.quote(requirement)}"


def _program() -> str:
    called = Path(sys.argv[0])
    if called.name == "__main__.py" and called.parent.name == "gsiirl":
        return f"{shlex.quote(sys.executable)} -m gsiirl"
    found = shutil.which("gsiirl")
    if called.stem == "gsiirl" and called.exists() and not (found and called.samefile(found)):
        return shlex.quote(sys.argv[0])
    return "gsiirl"
