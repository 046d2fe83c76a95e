"""The vulnerabilities of hosts, from a CSV file: one row for each way to attack a host."""

import csv
import io
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from gsiirl.errors import InputError
from gsiirl.scenarios.file_content import some
from gsiirl.scenarios.network import shown

REQUIRED = ("host", "name")
CHANCES = ("probability", "cvss")
"""One of these is required."""
OPTIONAL = ("source", "attack_cost", "value")
COLUMNS = REQUIRED + CHANCES + OPTIONAL

SURE, HARDLY = 0.95, 0.05
"""No score makes an attack certain or impossible."""
SEVERE = (4.0, 7.0, 9.0)
"""CVSS base scores from which a vulnerability is of medium, high and critical severity."""


@dataclass(frozen=True)
class CvssRule:
    """How a CVSS base score becomes the probability that one try succeeds.

    Attributes:
        of_severity: probabilities for low, medium, high and critical severity; without them a tenth of the score,
            not below `HARDLY` nor above `SURE`.
    """

    of_severity: tuple[float, ...] | None = None

    @classmethod
    def of(cls, text: str) -> "CvssRule":
        """The rule that a flag names: `score`, or four probabilities.

        Raises:
            InputError: it is neither.
        """
        if text.strip() == "score":
            return cls()
        try:
            numbers = tuple(float(number) for number in text.split(","))
        except ValueError:
            numbers = ()
        if len(numbers) != 4 or not all(0 < number <= 1 for number in numbers):
            mend = "give score, or four numbers in (0, 1] for low, medium, high and critical, such as 0.2,0.4,0.6,0.8"
            raise InputError("probability-of-cvss", f"cannot be '{shown(text)}'", mend)
        return cls(numbers)

    def __call__(self, score: float) -> float:
        """The probability for a score above 0."""
        if self.of_severity is not None:
            return self.of_severity[sum(score >= bound for bound in SEVERE)]
        return min(max(round(score / 10, 6), HARDLY), SURE)

    def __str__(self) -> str:
        if self.of_severity is None:
            return f"cvss / 10, not below {HARDLY:g} nor above {SURE:g}"
        low, medium, high, critical = (f"{number:g}" for number in self.of_severity)
        return f"{low} below 4, {medium} from 4, {high} from 7 and {critical} from 9 on"


@dataclass(frozen=True)
class Vulnerability:
    """A way to attack a host: a row of the file, which begins at `line`."""

    line: int
    host: str
    name: str
    probability: float | None
    """That a try succeeds; None where the CVSS score is 0, which is given to what is no vulnerability."""
    by_cvss: bool
    source: str | None
    """The one host that it can be attacked from, or "outside"; None for every neighbour."""
    attack_cost: float
    value: float | None
    """Of the host, to the attacker."""


@dataclass(frozen=True)
class Vulnerabilities:
    """What the file lists, and what is to be said of it."""

    rows: list[Vulnerability]
    notes: list[str]


def read_vulnerabilities(path: Path, rule: CvssRule) -> Vulnerabilities:
    """Read a CSV file with a header: UTF-8, columns separated by commas.

    Raises:
        InputError: it cannot be read, or a row holds what it cannot; it names the file, the line and the column.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except (OSError, ValueError) as error:
        if isinstance(error, UnicodeDecodeError):
            line = error.object.count(b"\n", 0, error.start) + 1
            raise InputError(f"{path}: line {line}", "is not UTF-8 text", "save it as 'CSV UTF-8'") from None
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(str(path), f"cannot be read ({reason})", "give a readable file") from None
    first = text.partition("\n")[0]
    for mark, word in ((";", "';'"), ("\t", "tabs")):
        if mark in first and "," not in first:
            raise InputError(f"{path}: line 1", f"separates columns by {word}", "save it with commas between them")
    lines = _lines(path, text)
    header = next(lines, None)
    if header is None:
        raise InputError(str(path), "is empty", f"begin it with the columns {', '.join(COLUMNS)}")
    columns, notes = _columns(path, *header)
    rows = [_row(path, line, dict(zip(columns, cells, strict=True)), rule) for line, cells in lines]
    if not rows:
        raise InputError(str(path), "has no row below its header", "give a row for each vulnerability")
    nothing = [str(row.line) for row in rows if row.probability is None]
    if nothing:
        notes.append(f"a cvss of 0 is no vulnerability: left out line {some(nothing, 12)}")
    if any(row.by_cvss for row in rows):
        notes.append(f"probability = {rule} (--probability-of-cvss or a column probability says otherwise)")
    return Vulnerabilities(rows, notes)


def near(typed: str, names: Sequence[str]) -> str:
    """The name that may have been meant, as a question to append; empty where none is near."""
    folded = {name.casefold(): name for name in reversed(names)}
    found = get_close_matches(typed.casefold(), list(folded), n=1)
    return f" (did you mean {shown(folded[found[0]])}?)" if found else ""


def _lines(path: Path, text: str) -> Iterator[tuple[int, list[str]]]:
    """The number of every record's first line, and its cells; all have as many as the first."""
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    begun, width = 1, None
    try:
        for cells in reader:
            line, begun = begun, reader.line_num + 1
            cells = [" ".join(cell.split()) for cell in cells]
            if not any(cells):
                continue
            width = width or len(cells)
            if len(cells) != width:
                problem = f"has {len(cells)} cells for {width} columns"
                raise InputError(f"{path}: line {line}", problem, 'put text that holds a comma between " and "')
            yield line, cells
    except csv.Error as error:
        raise InputError(f"{path}: line {begun}", f"is not CSV ({error})", "mend it or save it as CSV again") from None


def _columns(path: Path, line: int, header: Sequence[str]) -> tuple[list[str], list[str]]:
    """The columns by our names, and what is to be said of them."""
    field = f"{path}: line {line}"
    columns = ["_".join(name.lower().split()) for name in header]
    for name in columns:
        if name in COLUMNS and columns.count(name) > 1:
            raise InputError(f"{field}, column {name}", "is there twice", "keep one of the two")
    others = [name for name, column in zip(header, columns, strict=True) if column not in COLUMNS]
    lacking = [name for name in REQUIRED if name not in columns]
    if not set(CHANCES) & set(columns):
        lacking.append(" or ".join(CHANCES))
    # What is missing may have been meant by another name; else a column that is optional.
    wanted = [each for name in lacking for each in (CHANCES if name not in REQUIRED else (name,))]
    free = wanted or [name for name in COLUMNS if name not in columns]
    meant = [f"'{shown(name)}'{near(name, free)}" for name in others if name]
    if lacking:
        mend = f"add them, or rename {some(meant, 4)}" if meant else "add them"
        raise InputError(field, f"columns are missing: {', '.join(lacking)}", mend)
    return columns, [f"columns that are not read: {some(meant, 12)}"] if meant else []


WANTED: Mapping[str, tuple[str, float, float]] = {
    "probability": ("a number above 0 and at most 1", math.ulp(0.0), 1.0),
    "cvss": ("a base score from 0 to 10", 0.0, 10.0),
    "attack_cost": ("0 or more", 0.0, sys.float_info.max),
    "value": ("a finite number", -sys.float_info.max, sys.float_info.max),
}
"""What a number of a column can be: in words, the least and the most."""


def _row(path: Path, line: int, cells: Mapping[str, str], rule: CvssRule) -> Vulnerability:
    def number(column: str) -> float | None:
        text = cells.get(column)
        return _number(text, f"{path}: line {line}, {column}", *WANTED[column]) if text else None

    if not cells["host"]:
        raise InputError(f"{path}: line {line}, host", "is empty", "name the host")
    probability, cvss = number("probability"), number("cvss")
    if probability is None and cvss is None:
        there = [column for column in CHANCES if column in cells]
        raise InputError(f"{path}: line {line}, {' and '.join(there)}", "is empty", "give a number")
    by_cvss = probability is None and cvss != 0
    return Vulnerability(
        line=line,
        host=cells["host"],
        name=cells["name"],
        probability=rule(cvss) if by_cvss and cvss is not None else probability,
        by_cvss=by_cvss,
        source=cells.get("source") or None,
        attack_cost=number("attack_cost") or 0.0,
        value=number("value"),
    )


def _number(text: str, field: str, wanted: str, least: float, most: float) -> float:
    mend = f"give {wanted}"
    if text.count(",") == 1:
        mend += f", with a decimal point: {text.replace(',', '.')}"
    try:
        found = float(text.replace("_", "?"))
    except ValueError:
        found = math.nan
    if not least <= found <= most:
        raise InputError(field, f"is '{shown(text)}'", mend)
    return found
