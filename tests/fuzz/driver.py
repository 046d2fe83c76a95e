"""What every fuzzer of a reader shares: what must hold of any input, changed samples, and the run under Atheris.

A fuzzer is a module with a `TARGET` that ends in `main(TARGET)`. With Atheris and coverage installed (they are no
requirements of ours), this fuzzes, keeps in CORPUS what reaches new lines, and measures the lines reached:

    export PYTHONPATH=src:tests
    python -m fuzz.json_network -runs=100000 CORPUS
    coverage run --source=src/gsiirl/scenarios -m fuzz.json_network --replay CORPUS; coverage report

`test_fuzz.py` runs changed samples without Atheris.
"""

import importlib
import random
import re
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gsiirl.errors import InputError

WORD = re.compile(rb'"[^"]*"|[\w.+-]+|\s+|.', re.DOTALL)
EXTREMES = (
    "NaN",
    "-1",
    "0",
    "1e999",
    "1" * 400,
    "null",
    "true",
    "{}",
    '""',
    f'"{"x" * 5000}"',
    '"\\ud800"',
    '"\ud800"',
)
LONGEST = 5.0
"""Seconds that an input of a few kilobytes may take."""
LARGEST = 500
"""MiB by which the process may grow."""
LONGEST_LINE = 400
"""Characters of a refusal."""


@dataclass(frozen=True)
class Target:
    """A reader, and what it is given."""

    read: Callable[[bytes], object]
    """Reads an input, and asserts what must hold of the result."""
    samples: Sequence[bytes]
    """Valid inputs, and some that are refused."""
    words: Sequence[str]
    """What stands in such files."""
    package: str
    """Where the reader is, for Atheris to see which lines an input reaches."""


def check(target: Target, content: bytes) -> bool:
    """Read an input; whether it was accepted. Anything but a short refusal or a sound result is an error."""
    begin, refusal = time.monotonic(), None
    try:
        target.read(content)
    except InputError as error:
        refusal = str(error)
    assert time.monotonic() - begin < LONGEST, "the reader hangs"
    assert refusal is None or len(refusal.splitlines()) == 1, refusal
    assert refusal is None or len(refusal) <= LONGEST_LINE, f"{len(refusal)} characters: {refusal[:200]}"
    return refusal is None


def grown() -> float:
    """The largest memory of the process so far, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


class Changes:
    """Random changes of an input, most of which leave its syntax as it is, so that what reads on is reached."""

    def __init__(self, target: Target) -> None:
        added = [text.encode(errors="surrogatepass") for text in (*target.words, *EXTREMES)]
        self.words = [word for text in added for word in WORD.findall(text)]
        alike: dict[bytes, set[bytes]] = {}
        for word in (*self.words, *(word for sample in target.samples for word in WORD.findall(sample))):
            alike.setdefault(_kind(word), set()).add(word)
        self.alike = {kind: sorted(words) for kind, words in alike.items()}

    def change(self, content: bytes, source: random.Random) -> bytes:
        """The input with one to three changes."""
        words = WORD.findall(content) or [b""]
        for _ in range(source.randint(1, 3)):
            place = source.choice([place for place, word in enumerate(words) if word.strip()] or [0])
            word = words[place]
            match source.randrange(10):
                case 0:
                    words[place] = b""
                case 1:
                    words[place] = source.choice(self.words)
                case 2:
                    begin = source.randint(0, len(word))
                    words[place] = word[:begin] + source.randbytes(1) + word[begin + 1 :]
                case 3:
                    end = place + source.randint(1, 20)
                    words[place:end] = words[place:end] * 2
                case _:
                    words[place] = source.choice(self.alike.get(_kind(word), [word]))
        return b"".join(words)


def _kind(word: bytes) -> bytes:
    """What may take a word's place: text for text, number for number; a bracket stays what it is."""
    if word[:1] == b'"':
        return b'"'
    return b"0" if word[:1].isdigit() or word[:1] in (b"-", b"N") else b"a" if word[:1].isalpha() else word


def changed_samples(target: Target, number: int, seed: int) -> Iterator[bytes]:
    """Samples with a few random changes each: the same for the same seed."""
    source, changes = random.Random(seed), Changes(target)
    for _ in range(number):
        yield changes.change(source.choice(target.samples), source)


def main(target: Target) -> None:
    """Fuzz the target as the command line says."""
    if sys.argv[1:2] == ["--replay"]:
        inputs = [*target.samples, *(path.read_bytes() for folder in sys.argv[2:] for path in Path(folder).iterdir())]
        accepted = sum(check(target, content) for content in inputs)
        print(f"{len(inputs)} inputs, {accepted} accepted")
        return
    atheris: Any = importlib.import_module("atheris")
    # Modules that are imported already (the reader among them) are given Atheris's probes in place.
    for name, module in sorted(sys.modules.items()):
        if name.startswith(target.package):
            for function in vars(module).values():
                if callable(function) and getattr(function, "__module__", "") == name:
                    _instrument(atheris, function)
    with tempfile.TemporaryDirectory() as folder:
        seeds, words = Path(folder, "seeds"), Path(folder, "words")
        seeds.mkdir()
        for position, sample in enumerate(target.samples):
            (seeds / str(position)).write_bytes(sample)
        words.write_text("".join(f'"{_escaped(word)}"\n' for word in target.words))
        limits = [
            f"-timeout={LONGEST:.0f}",
            f"-rss_limit_mb={grown() + LARGEST:.0f}",
            f"-dict={words}",
            "-max_len=8192",
        ]
        changes = Changes(target)

        def mutate(content: bytes, longest: int, seed: int) -> bytes:
            """Our changes every other time, and those that libFuzzer would make."""
            if seed % 2:
                return changes.change(content, random.Random(seed))[:longest]
            return atheris.Mutate(content, longest)

        # The first folder is where new inputs are kept.
        arguments = [*sys.argv, str(seeds), *limits]
        atheris.Setup(arguments, lambda content: check(target, content), custom_mutator=mutate)
        atheris.Fuzz()


def _instrument(atheris: Any, thing: Any) -> None:
    if isinstance(thing, type):
        for part in vars(thing).values():
            function = getattr(part, "__func__", getattr(part, "fget", part))
            if callable(function) and hasattr(function, "__code__"):
                atheris.instrument_func(function)
    elif hasattr(thing, "__code__"):
        atheris.instrument_func(thing)


def _escaped(word: str) -> str:
    return "".join(f"\\x{byte:02x}" for byte in word.encode())
