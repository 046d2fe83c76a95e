"""What the pages of docs print is what their programs print."""

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
PAGES = ["how-to/own-game.md", "how-to/own-expert.md", "commitment.md"]
PAGES += [f"special-cases/{case}.md" for case in ("cooperative", "competitive", "classic")]
NUMBER = r"-?\d+(?:\.\d*)?"


def programs_and_outputs(page: Path) -> tuple[str, str]:
    """The Python of a page as one program, and everything the page says that it prints."""
    blocks = re.findall(r"^```(\w*)\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)
    program = "\n".join(text for language, text in blocks if language == "python")
    return program, "".join(text for language, text in blocks if language == "")


def printed_by(program: str, folder: Path) -> str:
    arguments = [sys.executable, "-c", program]
    return subprocess.run(arguments, check=True, capture_output=True, text=True, cwd=folder).stdout


@pytest.mark.slow
def test_the_program_of_a_continuous_game_of_ones_own_finds_what_the_cat_wants(tmp_path: Path) -> None:
    program, _ = programs_and_outputs(DOCS / "how-to" / "own-continuous-game.md")
    printed = printed_by(program, tmp_path)
    assert "the cat likes best to be at (0.50, 0.50)" in printed
    [real, known] = re.findall(r"robot (-?\d+\.\d+), cat (-?\d+\.\d+)", printed)
    assert float(real[0]) == pytest.approx(float(known[0]), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_the_programs_of_a_page_print_what_the_page_says(page: str, tmp_path: Path) -> None:
    program, said = programs_and_outputs(DOCS / page)
    shutil.copytree(DOCS.parent / "examples", tmp_path / "examples")
    assert_same(printed_by(program, tmp_path), said)


@pytest.mark.slow
def test_the_program_about_pettingzoo_prints_what_the_page_says_of_the_run_that_it_makes(tmp_path: Path) -> None:
    page = DOCS / "how-to" / "pettingzoo.md"
    [command] = re.findall(r"^\$ gsiirl (.*)$", page.read_text(), re.MULTILINE)
    arguments = [sys.executable, "-m", "gsiirl", *shlex.split(command), "--quiet"]
    subprocess.run(arguments, check=True, capture_output=True, cwd=tmp_path)
    program, said = programs_and_outputs(page)
    assert_same(printed_by(program, tmp_path), said)


def assert_same(printed: str, said: str) -> None:
    # Word for word; numbers may differ by what another processor's rounding makes of them.
    assert re.sub(NUMBER, "#", printed).split() == re.sub(NUMBER, "#", said).split()
    numbers = [[float(each) for each in re.findall(NUMBER, text)] for text in (printed, said)]
    assert numbers[0] == pytest.approx(numbers[1], abs=0.03)


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
