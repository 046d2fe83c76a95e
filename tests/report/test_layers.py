"""The folders of the report import each other one way."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import gsiirl.report

PACKAGE = Path(gsiirl.report.__file__).parent
assert gsiirl.report.__doc__ is not None
ORDER = [{folder.strip() for folder in step.split(",")} for step in gsiirl.report.__doc__.splitlines()[-1].split("|")]
"""As the package's docstring states it, lowest first."""
MOST_FILES = 12


def imported_folders(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        yield from (name.split(".")[2] for name in names if name.startswith("gsiirl.report."))


def step_of(folder: str) -> int:
    (step,) = [number for number, folders in enumerate(ORDER) if folder in folders]
    return step


def test_every_folder_has_its_place() -> None:
    folders = {path.parent.name for path in PACKAGE.glob("*/*.py")}
    assert folders == {folder for folders in ORDER for folder in folders}
    assert [path.name for path in PACKAGE.glob("*.py")] == ["__init__.py"]


@pytest.mark.parametrize("path", sorted(PACKAGE.glob("*/*.py")), ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_a_folder_imports_only_itself_and_those_before_it(path: Path) -> None:
    folder = path.parent.name
    foreign = {each for each in imported_folders(path) if each != folder}
    assert {each for each in foreign if step_of(each) >= step_of(folder)} == set()


@pytest.mark.parametrize("folder", ["", *sorted(folder for folders in ORDER for folder in folders)])
def test_no_folder_is_crowded(folder: str) -> None:
    assert 1 <= len(list((PACKAGE / folder).glob("*.py"))) <= MOST_FILES
