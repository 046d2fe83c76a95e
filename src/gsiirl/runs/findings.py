"""What a check of the theory found, as `theory.json` holds it: written by `gsiirl theory`, drawn by the report."""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from gsiirl.errors import InputError
from gsiirl.runs.json_file import encode_json, read_versioned_json, versioned, write_json

FINDINGS = "theory.json"


@dataclass(frozen=True)
class Measurement:
    """One number, with the bounds that the claim sets it, if any."""

    name: str
    """What was measured, in words."""
    value: float
    at_least: float | None = None
    at_most: float | None = None
    unit: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the value is within its bounds; None where there are none."""
        if self.at_least is None and self.at_most is None:
            return None
        above = self.at_least is None or self.value >= self.at_least
        return above and (self.at_most is None or self.value <= self.at_most)


@dataclass(frozen=True)
class Curve:
    """A line of a figure: `spread` is the half width of a band around `y`, [] where there is none."""

    name: str
    x: list[float]
    y: list[float]
    spread: list[float] = field(default_factory=list)
    role: str = "ours"
    """`ours`, `paper` (as the paper prints it) or `guide` (a slope to compare with): decides the look."""


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

    key: str
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

    @property
    def holds(self) -> bool:
        """Whether every bounded measurement is within its bounds."""
        return all(each.holds is not False for each in self.measurements)


@dataclass(frozen=True)
class Findings:
    """All findings of one call of `gsiirl theory`."""

    quick: bool
    findings: list[Finding]
    environment: dict[str, str] = field(default_factory=dict)

    def write(self, folder: Path) -> None:
        """Write `theory.json` into `folder`."""
        write_json(folder / FINDINGS, self.json())

    def encode(self) -> bytes:
        """The bytes of `theory.json`."""
        return encode_json(FINDINGS, self.json())

    def json(self) -> dict[str, Any]:
        """The content of `theory.json`; each measurement and finding says whether it `holds`."""
        findings = []
        for finding in self.findings:
            content = asdict(finding) | {"holds": finding.holds}
            content["measurements"] = [asdict(each) | {"holds": each.holds} for each in finding.measurements]
            findings.append(content)
        return versioned(
            {"generator": "gsiirl theory", "quick": self.quick, "environment": self.environment, "findings": findings}
        )

    @classmethod
    def read(cls, folder: Path) -> "Findings":
        """Read `theory.json` from `folder`.

        Raises:
            InputError: missing, damaged, or of another format.
        """
        path = folder / FINDINGS
        content = read_versioned_json(path, "run gsiirl theory again")
        try:
            return cls(
                quick=bool(content["quick"]),
                findings=[_finding(each) for each in content["findings"]],
                environment=dict(content["environment"]),
            )
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise InputError(str(path), f"is damaged ({error!r})", "run gsiirl theory again") from error


def _finding(content: dict[str, Any]) -> Finding:
    values = {name: value for name, value in content.items() if name != "holds"}
    values["measurements"] = [
        Measurement(**{name: value for name, value in each.items() if name != "holds"})
        for each in content["measurements"]
    ]
    values["panels"] = [
        Panel(**(each | {"curves": [Curve(**curve) for curve in each["curves"]]})) for each in content["panels"]
    ]
    return Finding(**values)
