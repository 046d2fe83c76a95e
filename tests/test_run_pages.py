"""scripts/run_pages.py runs what pages show, and compares it with what they say."""

from pathlib import Path

import pytest
import run_pages

EXAMPLE = Path(__file__).parents[1] / "examples" / "deer.py"
TUTORIAL = Path(__file__).parents[1] / "docs" / "tutorials" / "first-reward.md"


def fence(first: str, text: str) -> str:
    return f"```{first}\n{text}\n```\n"


def test_a_page_that_prints_what_it_says_has_no_faults() -> None:
    page = fence("python", "a = 2") + "Then\n\n" + fence("python", "print('two', a)") + fence("", "two 2")
    assert list(run_pages.faults(page)) == []


def test_another_number_or_another_word_is_a_fault() -> None:
    for said in ("two 2.1", "three 2"):
        page = "A page.\n\n" + fence("python", "print('two', 2)") + fence("", said)
        [fault] = run_pages.faults(page)
        assert fault.startswith("line 3: it prints\n    two 2\n")


def test_numbers_may_differ_by_rounding_and_where_the_page_says_about() -> None:
    assert list(run_pages.faults(fence("python", "print(2.0)") + fence("", "2.02"))) == []
    assert list(run_pages.faults(fence("python", "print(2.0)") + fence("text about", "7.0"))) == []


def test_a_block_that_fails_is_named_by_its_line() -> None:
    page = fence("python", "print(1)") + fence("", "1") + fence("python", "1 / 0")
    [fault] = run_pages.faults(page)
    assert fault.startswith("line 7: it fails")
    assert "ZeroDivisionError" in fault


def test_the_blocks_of_a_page_share_a_folder_with_the_examples() -> None:
    page = fence("sh", "echo hello > new.txt") + fence("python", "print(open('new.txt').read())") + fence("", "hello")
    page += fence("console", "$ ls examples/office.json\nexamples/office.json\n$ ls new.txt\nnew.txt")
    assert list(run_pages.faults(page)) == []


def test_a_shell_block_that_fails_is_a_fault() -> None:
    [fault] = run_pages.faults(fence("sh", "false\necho after"))
    assert fault.startswith("line 1: it fails")


def test_a_command_that_is_not_marked_is_a_fault() -> None:
    for first in ("", "text", "bash"):
        [fault] = run_pages.faults(fence(first, "gsiirl list"))
        assert "begin the block with ```sh" in fault


def test_blocks_marked_norun_are_listed_and_not_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_pages, "ROOT", tmp_path)
    page = tmp_path / "page.md"
    page.write_text(fence("sh norun", "touch made\nfalse"))
    assert run_pages.check(page, tmp_path, "package") == []
    assert list(run_pages.not_run([page])) == ["page.md:1: touch made (and 1 lines more)"]


def test_a_page_is_run_again_only_when_it_or_the_package_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_pages, "ROOT", tmp_path)
    (tmp_path / "examples").mkdir()
    runs = tmp_path / "runs"
    page, cache = tmp_path / "page.md", tmp_path / "cache"
    cache.mkdir()
    text = fence("sh", f"echo run >> {runs}")
    for words, package in (("", "one"), ("", "one"), ("other words", "one"), ("", "two")):
        page.write_text(text + words)
        assert run_pages.check(page, cache, package) == []
    assert runs.read_text() == "run\nrun\n"


def test_a_page_that_fails_is_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_pages, "ROOT", tmp_path)
    (tmp_path / "examples").mkdir()
    page = tmp_path / "page.md"
    page.write_text(fence("sh", "false"))
    for _ in range(2):
        assert run_pages.check(page, tmp_path, "package")


def test_the_example_of_the_first_tutorial_is_its_program() -> None:
    program = "".join(step.block.text for step in run_pages.steps(run_pages.blocks(TUTORIAL.read_text())))
    example = EXAMPLE.read_text().partition("def encounter")[0]
    lines = [line for line in example.splitlines()[1:] if line]
    assert [line for line in program.splitlines() if line and not line.startswith("print(problem)")][
        : len(lines)
    ] == lines
