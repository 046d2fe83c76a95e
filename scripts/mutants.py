"""Changes the source in small ways, one at a time, and sees whether the tests notice.

A sample of changes ("mutants") is drawn equally over the folders that hold the mathematics. Each is made in a copy of
the tree; then the tests of the same folder run, without the slow ones. A mutant is killed where a test fails, survives
where all pass, and is neither where the tests take longer than the limit. Strings, docstrings and annotations are left
alone.

    .venv/bin/python -m pip install cosmic-ray          # not in the lock: nothing else needs it
    .venv/bin/python scripts/mutants.py --seed 0 --number 150 --out mutants.jsonl

One line of JSON a mutant; what is in the file already is not run again.
"""

import argparse
import ast
import collections
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import cosmic_ray.mutating
import cosmic_ray.plugins
from cosmic_ray.commands.init import _all_work_items  # pyright: ignore[reportPrivateUsage]

FOLDERS = ("learners", "irl", "equilibria", "hypergradients", "rewards", "games")
COPIED = ("src", "tests", "docs", "README.md", "pyproject.toml")
LIMIT = 900
"""Seconds that the tests of one mutant may take."""


class Mutant(NamedTuple):
    """One change: the `occurrence`-th that `operator` can make in `module`, at `line`."""

    module: str
    operator: str
    arguments: str
    occurrence: int
    line: int

    @property
    def folder(self) -> str:
        """The folder below src/gsiirl, which is also that of its tests."""
        return Path(self.module).parts[2]


def main() -> None:
    """Draw the sample and run it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--number", type=int, default=150)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    root = Path(__file__).parents[1]
    done = {}
    if arguments.out.exists():
        lines = [json.loads(line) for line in arguments.out.read_text().splitlines()]
        done = {tuple(line["mutant"]): line["outcome"] for line in lines}
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in COPIED:
            source = root / name
            (shutil.copytree if source.is_dir() else shutil.copy)(source, copy / name)
        for mutant in sample(copy, arguments.seed, arguments.number):
            if tuple(mutant) not in done:
                outcome, change = tried(copy, mutant)
                done[tuple(mutant)] = outcome
                with arguments.out.open("a") as file:
                    file.write(json.dumps({"mutant": mutant, "outcome": outcome, "change": change}) + "\n")
            print(done[tuple(mutant)], *mutant, flush=True)
    print(dict(collections.Counter(done.values())))


def sample(root: Path, seed: int, number: int) -> list[Mutant]:
    """As many mutants of each folder, in turn."""
    rng = random.Random(seed)
    drawn = []
    for folder in FOLDERS:
        every = sorted(of_folder(root, folder))
        drawn.append(rng.sample(every, min(len(every), -(-number // len(FOLDERS)))))
    return [mutant for turn in zip(*drawn, strict=False) for mutant in turn][:number]


def of_folder(root: Path, folder: str) -> Iterator[Mutant]:
    """Every mutant of a folder's modules, outside annotations."""
    for path in sorted((root / "src/gsiirl" / folder).rglob("*.py")):
        spared = annotations(path)
        for item in _all_work_items([path], {}):
            [change] = item.mutations
            if not any(start <= change.start_pos <= end for start, end in spared):
                arguments = json.dumps(change.operator_args, sort_keys=True)
                name = str(path.relative_to(root))
                yield Mutant(name, change.operator_name, arguments, change.occurrence, change.start_pos[0])


def annotations(path: Path) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """First and last (line, column) of every annotation and decorator."""
    spans = []
    for node in ast.walk(ast.parse(path.read_text())):
        parts = [getattr(node, name, None) for name in ("annotation", "returns")]
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            parts += node.decorator_list
        for part in parts:
            if isinstance(part, ast.expr):
                end = (part.end_lineno or part.lineno, part.end_col_offset or part.col_offset)
                spans.append(((part.lineno, part.col_offset), end))
    return spans


def tried(root: Path, mutant: Mutant) -> tuple[str, str]:
    """What became of a mutant, and the line that it changed."""
    path = root / mutant.module
    before = path.read_text()
    operator = cosmic_ray.plugins.get_operator(mutant.operator)(**json.loads(mutant.arguments))
    after = cosmic_ray.mutating.mutate_code(before, operator, mutant.occurrence)
    if after is None:
        return "impossible", ""
    pairs = zip(before.splitlines(), after.splitlines(), strict=False)
    change = " -> ".join(next(((old.strip(), new.strip()) for old, new in pairs if old != new), ("", "")))
    path.write_text(after)
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-m", "not slow", "-p", "no:cacheprovider"]
    # The module's own tests first: they kill it soonest.
    own = Path("tests", *path.relative_to(root / "src/gsiirl").parts[:-1], f"test_{path.name}")
    command += [str(own)] if (root / own).is_file() else []
    command += [f"tests/{mutant.folder}"]
    try:
        # No compiled module may outlive the change it was compiled from.
        environment = os.environ | {"PYTHONPATH": str(root / "src"), "PYTHONDONTWRITEBYTECODE": "1"}
        finished = subprocess.run(command, cwd=root, capture_output=True, timeout=LIMIT, check=False, env=environment)
        outcome = "survived" if finished.returncode == 0 else "killed"
    except subprocess.TimeoutExpired:
        outcome = "timeout"
    finally:
        path.write_text(before)
    return outcome, change


if __name__ == "__main__":
    main()
