"""Commands that are printed work when they are pasted."""

import importlib.util
import shutil
import sys
from pathlib import Path

import pytest

from gsiirl.program.command import command, installing


@pytest.fixture
def script(tmp_path: Path) -> str:
    path = tmp_path / "my bin" / "gsiirl"
    path.parent.mkdir()
    path.write_text("#!/bin/sh\n")
    path.chmod(0o755)
    return str(path)


def test_a_program_that_is_found_is_called_by_its_name(script: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "argv", [script, "run"])
    monkeypatch.setenv("PATH", str(Path(script).parent))
    assert command("resume", Path("my run")) == "gsiirl resume 'my run'"


def test_one_that_is_not_found_is_called_as_it_was(script: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "argv", [script, "run"])
    monkeypatch.setenv("PATH", "/nowhere")
    assert command("report", "x", "--out", "y") == f"'{script}' report x --out y"
    monkeypatch.setattr(sys, "argv", [str(Path("somewhere") / "gsiirl" / "__main__.py")])
    assert command("report") == f"{sys.executable} -m gsiirl report"
    monkeypatch.setattr(sys, "argv", ["pytest"])
    assert command("report") == "gsiirl report"


@pytest.mark.parametrize("pip", [True, False])
def test_a_package_is_installed_beside_this_python_with_what_there_is(pip: bool, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object() if pip else None)
    how = f"{sys.executable} -m pip install" if pip else f"uv pip install --python {sys.executable}"
    assert installing("mpe2>=1.1.1") == f"{how} 'mpe2>=1.1.1'"
    assert shutil.which(sys.executable)
