"""What a check of the theory found, as `theory.json` holds it: written by `gsiirl theory`, drawn by the report."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, StringConstraints

from gsiirl.program.presence import is_there
from gsiirl.runs.files.checksum import carries_checksum
from gsiirl.runs.files.json_file import as_typed, read_versioned_json, versioned, write_json

FINDINGS = "theory.json"


def _from_text(value: object) -> object:
    return float(value) if isinstance(value, str) and value in ("nan", "inf", "-inf") else value


Number = Annotated[float, BeforeValidator(_from_text)]
"""A number that may be NaN or infinite, which JSON has no words for: it is a text there."""


@dataclass(frozen=True)
class Measurement:
    """One number, with the bounds that the claim sets it, if any."""

    name: str
    """What was measured, in words."""
    value: Number
    at_least: Number | None = None
    at_most: Number | None = None
    unit: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the value is within its bounds; None where there are none. No number at all never holds."""
        if not math.isfinite(self.value):
            return False
        if self.at_least is None and self.at_most is None:
            return None
        above = self.at_least is None or self.value >= self.at_least
        return bool(above and (self.at_most is None or self.value <= self.at_most))


@dataclass(frozen=True)
class Curve:
    """A line of a figure: `spread` is the half width of a band around `y`, [] where there is none."""

    name: str
    x: list[Number]
    y: list[Number]
    spread: list[Number] = field(default_factory=list)
    role: str = "ours"
    """`ours`, `paper` (as the paper prints it) or `guide` (a slope to compare with): decides the look."""

    def __post_init__(self) -> None:
        if len(self.x) != len(self.y) or len(self.spread) not in (0, len(self.y)):
            raise ValueError(f"{self.name} has {len(self.x)} x, {len(self.y)} y, {len(self.spread)} spread")


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    title: str
    x_label: str
    y_label: str
    curves: list[Curve]
    log_x: bool = True
    log_y: bool = True


@dataclass(frozen=True)
class Finding:
    """A claim of the paper as we hold it, what the paper prints, and what was measured."""

    key: Annotated[str, StringConstraints(pattern="^[a-z0-9-]{1,60}$")]
    """Short name for files: `lemma-2`."""
    title: str
    claim: str
    """One or two sentences: what we hold to be true."""
    printed: str
    """One or two sentences: what the paper prints, where it differs; "" where it does not."""
    reading: str
    """One or two sentences: how to read the figures below, and what came out."""
    measurements: list[Measurement]
    panels: list[Panel] = field(default_factory=list)
    seconds: float = 0.0
    check: str = ""
    """The check that found it, as `gsiirl theory` names it."""

    @property
    def holds(self) -> bool:
        """Whether every bounded measurement is within its bounds, and every other one a finite number."""
        return not self.missed

    @property
    def missed(self) -> list[Measurement]:
        """The measurements that are out of their bounds, or no finite number."""
        return [each for each in self.measurements if each.holds is False]


@dataclass(frozen=True)
class Findings:
    """All findings of one call of `gsiirl theory`."""

    quick: bool
    findings: list[Finding]
    environment: dict[str, str] = field(default_factory=dict)
    missing: list[str] = field(default_factory=list)
    """Checks that have not ended, in words: [] unless the call was interrupted."""

    @property
    def missed(self) -> list[tuple[Finding, Measurement]]:
        """Every measurement that is out of its bounds, or no finite number."""
        return [(finding, each) for finding in self.findings for each in finding.missed]

    def write(self, folder: Path) -> None:
        """Write `theory.json` into `folder`."""
        write_json(folder / FINDINGS, self.json())

    def json(self) -> dict[str, Any]:
        """The content of `theory.json`; each measurement and finding says whether it `holds`.

        JSON has no NaN and no infinity: they are written as the texts "nan", "inf" and "-inf".
        """
        findings = []
        for finding in self.findings:
            content = asdict(finding) | {"holds": finding.holds}
            content["measurements"] = [asdict(each) | {"holds": each.holds} for each in finding.measurements]
            findings.append(_numbers_as_json(content))
        return versioned(
            {
                "generator": "gsiirl theory",
                "quick": self.quick,
                "environment": self.environment,
                "missing": self.missing,
                "findings": findings,
            }
        )

    @staticmethod
    def is_at(folder: Path) -> bool:
        """Whether `folder` holds findings, sound or damaged."""
        return is_there(folder / FINDINGS)

    @classmethod
    def read(cls, folder: Path) -> "Findings":
        """Read `theory.json` from `folder`.

        Raises:
            InputError: missing, damaged, or of another format.
        """
        path, mend = folder / FINDINGS, "run gsiirl theory again in another folder"
        content = read_versioned_json(path, mend)
        findings = as_typed(cls, content, path, mend)
        carries_checksum(content, folder)
        return findings


def _numbers_as_json(content: Any) -> Any:
    if isinstance(content, dict):
        return {name: _numbers_as_json(value) for name, value in content.items()}
    if isinstance(content, Sequence) and not isinstance(content, str):
        return [_numbers_as_json(value) for value in content]
    if content is None or isinstance(content, str | bool | int):
        return content
    # Also NumPy's and JAX's own numbers.
    number = float(content)
    return number if math.isfinite(number) else str(number)
