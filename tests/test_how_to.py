"""What the how-tos say of their programs, beyond what `make docs` compares (scripts/run_pages.py)."""

import re
import shlex
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from gsiirl.cli import main
from gsiirl.experiments.security import cost, network_check

DOCS = Path(__file__).parents[1] / "docs"


def program_of(page: Path) -> str:
    """The Python of a page as one program."""
    return "\n".join(re.findall(r"^```python\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE))


def printed_by(program: str, folder: Path) -> str:
    arguments = [sys.executable, "-c", program]
    return subprocess.run(arguments, check=True, capture_output=True, text=True, cwd=folder).stdout


@pytest.mark.slow
def test_the_program_of_a_continuous_game_of_ones_own_finds_what_the_cat_wants(tmp_path: Path) -> None:
    printed = printed_by(program_of(DOCS / "how-to" / "own-continuous-game.md"), tmp_path)
    assert "the cat likes best to be at (0.50, 0.50)" in printed
    [real, known] = re.findall(r"robot (-?\d+\.\d+), cat (-?\d+\.\d+)", printed)
    assert float(real[0]) == pytest.approx(float(known[0]), rel=0.05)


def test_a_finite_game_of_ones_own_takes_thirty_lines() -> None:
    [first, *_] = re.findall(r"```python\n(.*?)```", (DOCS / "how-to" / "own-game.md").read_text(), re.DOTALL)
    assert len(first.splitlines()) <= 30


def test_the_network_commands_print_what_the_page_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (DOCS / "how-to" / "own-topology.md").read_text()
    shutil.copytree(DOCS.parent / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    for module in (cost, network_check):
        monkeypatch.setattr(module, "available_memory", lambda: 20 * 10**9)
    sessions = re.findall(r"^ *```console\n *\$ gsiirl (.*?)\n(.*?)^ *```", page, re.DOTALL | re.MULTILINE)
    assert len(sessions) == 4
    for command, said in sessions:
        main(shlex.split(command))
        printed = capsys.readouterr()
        assert printed.err + printed.out == textwrap.dedent(said), command
    assert textwrap.indent((tmp_path / "examples" / "clinic.csv").read_text(), "   ") in page
