"""Run what the pages show, and compare what it prints with what the page says.

    python scripts/run_pages.py [PAGE ...] [--jobs N] [--cache FOLDER]

The blocks of a page are one session: they share their variables and an empty folder, in which `examples` lies.

| a block that begins with | is |
|---|---|
| ```python | run |
| ```sh | run by the shell |
| ```console | run where a line begins with `$ `; the other lines are what that prints, numbers aside |
| ``` | what the block before it prints; of ```text about the numbers may be others |
| ```python norun, ```sh norun | not run, and listed at the end |

A page that has run before is not run again until it, the package or the examples change.
"""

import argparse
import hashlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from platformdirs import user_cache_path

from gsiirl.program_cache import keep_programs

ROOT = Path(__file__).parents[1]
FENCE = re.compile(r"^(?P<indent> *)```(?P<info>[^`\n]*)\n(?P<text>.*?)^(?P=indent)```$", re.DOTALL | re.MULTILINE)
NUMBER = r"-?\d+(?:\.\d*)?"
ROUNDING = 0.03
"""By how much a number may differ: by what another processor's rounding makes of it."""
MARK = "--- the next block ---"
COMMAND = re.compile(r"\s*(gsiirl|make|pip|python|time) ")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    line: int
    language: str
    words: tuple[str, ...]
    text: str

    @property
    def runs(self) -> bool:
        return self.language in ("python", "sh", "console")


@dataclass(frozen=True)
class Step:
    """A block that is run, and what the page says that it prints: nothing, where the page does not say."""

    block: Block
    said: str | None
    about: bool

    @property
    def program(self) -> str:
        """Python that runs the block."""
        if self.block.language == "python":
            return self.block.text
        lines = [self.block.text]
        if self.block.language == "console":  # a command may fail: what it prints is what counts
            lines = [f"{command} || true" for command in commands(self.block.text)]
        script = "exec 2>&1\nset -e\n" + "\n".join(lines)
        return f"import subprocess\nsubprocess.run(['sh', '-c', {script!r}], check=True)\n"


def blocks(page: str) -> list[Block]:
    """The fenced blocks of a page."""
    found = []
    for each in FENCE.finditer(page):
        language, *words = each["info"].split() or [""]
        line = page.count("\n", 0, each.start()) + 1
        found.append(Block(line, language, tuple(words), textwrap.dedent(each["text"])))
    return found


def commands(console: str) -> list[str]:
    """The lines of a console block that are typed."""
    return [line.removeprefix("$ ") for line in console.splitlines() if line.startswith("$ ")]


def steps(found: Iterable[Block]) -> list[Step]:
    """What is run of a page, in order."""
    made: list[Step] = []
    for block in found:
        if block.runs and "norun" not in block.words:
            said = None
            if block.language == "console":
                said = "\n".join(line for line in block.text.splitlines() if not line.startswith("$ "))
            made.append(Step(block, said, about=block.language == "console"))
        elif block.language in ("", "text") and made and made[-1].said is None:
            made[-1] = Step(made[-1].block, block.text, "about" in block.words)
    return made


def difference(printed: str, said: str, *, about: bool) -> str | None:
    """How what was printed differs from what the page says: not at all if None."""
    words = [re.sub(NUMBER, "#", text).split() for text in (printed, said)]
    numbers = [[float(each) for each in re.findall(NUMBER, text)] for text in (printed, said)]
    alike = words[0] == words[1] and (
        about or all(abs(one - other) <= ROUNDING for one, other in zip(*numbers, strict=True))
    )
    return (
        None
        if alike
        else f"it prints\n{textwrap.indent(printed, '    ')}and the page says\n{textwrap.indent(said, '    ')}"
    )


def faults(page: str) -> Iterator[str]:
    """What is wrong with a page: blocks that fail, or print something else."""
    found = blocks(page)
    for block in found:
        command = block.language in ("", "text") and COMMAND.match(block.text)
        if command or (block.language in ("bash", "shell") and "norun" not in block.words):
            yield f"line {block.line}: a command: begin the block with ```sh, or ```sh norun"
    session = steps(found)
    if not session:
        return
    program = f"print({MARK!r}, flush=True)\n".join(f"{each.program}\n" for each in session)
    ran, printed = run(program)
    for step, text in zip(session, printed, strict=False):
        if step.said is not None and (wrong := difference(text, step.said, about=step.about)):
            yield f"line {step.block.line}: {wrong}"
    if ran.returncode:
        yield f"line {session[len(printed) - 1].block.line}: it fails\n{textwrap.indent(ran.stderr[-2000:], '    ')}"


def run(program: str) -> tuple[subprocess.CompletedProcess[str], list[str]]:
    """Run a program in an empty folder with the examples, and cut what it prints at the marks."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "examples", Path(folder) / "examples")
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
        ran = subprocess.run(
            [sys.executable, "-c", program],
            capture_output=True,
            text=True,
            cwd=folder,
            env={**os.environ, "PATH": path, "COLUMNS": "120", "MPLBACKEND": "agg"},
        )
    return ran, ran.stdout.split(f"{MARK}\n")


def package_key() -> str:
    """A digest of all that the blocks of a page may depend on besides the page."""
    digest = hashlib.sha256(sys.version.encode())
    for folder in ("src", "examples", "requirements", "scripts/run_pages.py"):
        path = ROOT / folder
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file() and file.suffix != ".pyc":
                digest.update(str(file.relative_to(ROOT)).encode() + file.read_bytes())
    return digest.hexdigest()


def check(page: Path, cache: Path, package: str) -> list[str]:
    """The faults of a page, which is run unless it ran well before."""
    text, name = page.read_text(), page.relative_to(ROOT).as_posix()
    shown = json.dumps([(each.language, each.words, each.text) for each in blocks(text)])
    known = cache / hashlib.sha256(f"{package} {name} {shown}".encode()).hexdigest()
    if known.exists():
        return []
    start = time.monotonic()
    found = [f"{name}, {each}" for each in faults(text)]
    if steps(blocks(text)):
        print(f"{name}: {'not ' if found else ''}as it says, {time.monotonic() - start:.0f} s", flush=True)
    if not found:
        known.touch()
    return found


def not_run(pages: Iterable[Path]) -> Iterator[str]:
    """The blocks that are marked `norun`."""
    for page in pages:
        for block in blocks(page.read_text()):
            if "norun" in block.words:
                lines = block.text.strip().splitlines()
                more = f" (and {len(lines) - 1} lines more)" if len(lines) > 1 else ""
                yield f"{page.relative_to(ROOT).as_posix()}:{block.line}: {lines[0].split('  ')[0]}{more}"


def main(arguments: list[str] | None = None) -> int:
    """Run the pages that are named, or all."""
    parser = argparse.ArgumentParser(description="Run what the pages show.")
    parser.add_argument("pages", nargs="*", type=Path, help="pages; all where none is named")
    parser.add_argument("--jobs", type=int, default=2, help="pages at once")
    parser.add_argument("--cache", type=Path, default=user_cache_path("gsiirl") / "pages", help="what ran well before")
    options = parser.parse_args(arguments)
    pages = [page.resolve() for page in options.pages] or [
        ROOT / "README.md",
        *(page for page in sorted((ROOT / "docs").rglob("*.md")) if "_build" not in page.parts),
    ]
    options.cache.mkdir(parents=True, exist_ok=True)
    package = package_key()
    # The longest first, so that none is left alone at the end.
    ordered = sorted(pages, key=lambda page: -len(steps(blocks(page.read_text()))))
    with ThreadPoolExecutor(options.jobs) as pool:
        found = [
            each for wrong in pool.map(lambda page: check(page, options.cache, package), ordered) for each in wrong
        ]
    print("not run:", *not_run(pages), sep="\n  ")
    for each in found:
        print(each, file=sys.stderr)
    again = shlex.join(str(page.relative_to(ROOT)) for page in pages) if options.pages else "all pages"
    print(f"{again}: {len(found)} faults" if found else f"{again}: as they say")
    return bool(found)


if __name__ == "__main__":
    # What one page has compiled no other need compile.
    keep_programs()
    sys.exit(main())
