"""Findings are read back as they were written."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from resealing import rewrite

from gsiirl.errors import InputError
from gsiirl.runs import Curve, Finding, Findings, Measurement, Panel


def a_finding(*measurements: Measurement, y: list[float] | None = None) -> Finding:
    curve = Curve("ours", [1.0, 2.0], y or [0.1, 1 / 3], [0.0, 0.5])
    panels = [Panel("title", "x", "y", [curve], log_x=False)]
    return Finding("key", "Title", "claim", "printed", "reading", list(measurements), panels, 1.5, "Check")


@pytest.mark.parametrize(
    ("value", "at_least", "at_most", "holds"),
    [
        (1.0, None, None, None),
        (1.0, 1.0, None, True),
        (1.0, None, 1.0, True),
        (1.0, 1.1, None, False),
        (1.0, None, 0.9, False),
        (1.0, 0.9, 1.1, True),
        (1.0, 0.2, 0.9, False),
        (math.nan, None, None, False),
        (math.nan, 0.0, None, False),
        (math.inf, 0.0, None, False),
    ],
)
def test_whether_a_bound_holds(value: float, at_least: float | None, at_most: float | None, holds: bool | None):
    assert Measurement("name", value, at_least, at_most).holds is holds


def test_a_finding_holds_when_no_bound_is_missed():
    free, held, missed = Measurement("a", 1.0), Measurement("b", 1.0, at_most=2.0), Measurement("c", 1.0, at_least=2.0)
    assert a_finding(free, held).holds
    assert not a_finding(free, held, missed).holds
    assert Findings(False, [a_finding(held), a_finding(missed)]).missed == [(a_finding(missed), missed)]


def test_findings_are_read_back_bit_for_bit(tmp_path: Path):
    findings = Findings(
        True,
        [a_finding(Measurement("n", 1 / 3, 0.1, 0.7, "s"), y=[math.inf, 1e-300]), a_finding()],
        {"gsiirl": "0.1"},
        ["Lemma 6"],
    )
    findings.write(tmp_path)
    assert Findings.read(tmp_path) == findings
    assert Findings.is_at(tmp_path)
    assert not Findings.is_at(tmp_path / "below")


def test_numbers_of_numpy_are_written_as_numbers(tmp_path: Path):
    value = np.float64(0.25)
    findings = Findings(False, [a_finding(Measurement("a", value, at_most=np.float64(1.0)), y=[value, value])])
    findings.write(tmp_path)
    content = json.loads((tmp_path / "theory.json").read_text())
    assert content["findings"][0]["measurements"][0] == {
        "name": "a",
        "value": 0.25,
        "at_least": None,
        "at_most": 1.0,
        "unit": "",
        "holds": True,
    }


def test_no_number_is_written_as_text(tmp_path: Path):
    Findings(False, [a_finding(Measurement("a", math.nan))]).write(tmp_path)
    text = (tmp_path / "theory.json").read_text()
    assert json.loads(text, parse_constant=pytest.fail)["findings"][0]["measurements"][0]["value"] == "nan"
    assert math.isnan(Findings.read(tmp_path).findings[0].measurements[0].value)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"findings"', '"found"'),
        ('"title": "Title"', '"heading": "Title"'),
        ('"value": 1.0', '"value": null'),
        ('"at_most": null', '"at_most": "much"'),
        ('"format_version": 1', '"format_version": 2'),
        ('"environment": {}', '"environment": 3'),
    ],
)
def test_damaged_findings_are_named_in_one_line(tmp_path: Path, old: str, new: str):
    Findings(False, [a_finding(Measurement("a", 1.0))]).write(tmp_path)
    path = tmp_path / "theory.json"
    rewrite(path, old, new)
    with pytest.raises(InputError) as error:
        Findings.read(tmp_path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)
