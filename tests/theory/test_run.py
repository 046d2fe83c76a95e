"""`gsiirl theory` with stand-ins for its checks."""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import jax
import jax.numpy as jnp
import pytest
from resealing import resealed

from gsiirl.cli import main
from gsiirl.runs import Curve, Finding, Findings, Measurement, Panel
from gsiirl.theory import run
from gsiirl.theory.run import CHECKS, Check

Run = Callable[..., tuple[int, str, str]]


class Stand:
    """A check that finds `value`, bounded by 1, and counts how often it is asked."""

    def __init__(self, name: str, value: float = 0.5) -> None:
        self.name, self.value = name, value
        self.calls: list[bool] = []
        self.error: BaseException | None = None

    def check(self, quick: bool) -> Finding | list[Finding]:
        self.calls.append(quick)
        if self.error is not None:
            raise self.error
        measurements = [Measurement(f"error of {self.name}", self.value, at_most=1.0)]
        curve = Curve("ours", [1.0, 2.0, 4.0], [1.0, 4.0, 16.0])
        # One figure is enough, for it takes long to draw.
        panels = [Panel("errors", "step", "error", [curve])] if self.name == "First" else []
        return Finding(self.name.lower(), self.name, "a claim", "", "a reading", measurements, panels)


@pytest.fixture
def checks(monkeypatch: pytest.MonkeyPatch) -> list[Stand]:
    """Three checks in the place of the real ones."""
    stands = [Stand(name) for name in ("First", "Second", "Third")]
    for stand in stands:
        module = ModuleType(f"stand_in_{stand.name}")
        module.__dict__["check"] = stand.check
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(run, "CHECKS", tuple(Check(f"stand_in_{stand.name}", stand.name) for stand in stands))
    return stands


@pytest.fixture
def theory(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Run:
    def call(*flags: str, out: Path | None = None) -> tuple[int, str, str]:
        status = main(["theory", *flags, "--out", str(out or tmp_path / "out")])
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return call


def content_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_every_check_of_the_list_is_there():
    # Their modules import JAX and are imported by name: a misspelt one would be found only when it runs.
    package = Path(run.__file__).parent / "checks"
    names = [check.module.removeprefix("gsiirl.theory.checks.") for check in CHECKS]
    assert sorted(names) == sorted(path.stem for path in package.glob("[!_]*.py"))
    assert len({check.title for check in CHECKS}) == len(CHECKS)


def test_findings_page_and_figures_are_written(checks: list[Stand], theory: Run, tmp_path: Path):
    status, shown, errors = theory("--quick")
    assert (status, errors) == (0, "")
    assert [check.calls for check in checks] == [[True]] * 3
    assert shown.splitlines()[-1] == str(tmp_path / "out" / "index.html")
    assert shown.count("holds") == 3
    assert "at most 1" in shown
    assert set(content_of(tmp_path / "out")) == {
        "theory.json",
        "index.html",
        "figures/first.png",
        "figures/first.svg",
    }
    found = Findings.read(tmp_path / "out")
    assert [(each.title, each.check, each.holds) for each in found.findings] == [
        (check.name, check.name, True) for check in checks
    ]
    assert (found.quick, found.missing) == (True, [])
    assert found.environment["jax"] == jax.__version__


def test_a_missed_bound_gives_status_one_and_a_line(checks: list[Stand], theory: Run, tmp_path: Path):
    checks[1].value = 1.25
    status, shown, errors = theory()
    assert status == 1
    assert errors == "gsiirl: missed 1 of the bounds: Second, error of Second\n"
    assert shown.count("MISSED") == 1
    assert checks[2].calls == [False]
    assert "missed in Second" in (tmp_path / "out" / "index.html").read_text()


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_what_is_no_number_is_missed_and_not_written_as_one(
    checks: list[Stand], theory: Run, tmp_path: Path, value: float
):
    checks[0].value = value
    status, shown, _ = theory()
    assert (status, shown.count("MISSED")) == (1, 1)
    text = (tmp_path / "out" / "theory.json").read_text()
    assert json.loads(text, parse_constant=pytest.fail)["findings"][0]["measurements"][0]["value"] == str(value)
    assert not Findings.read(tmp_path / "out").findings[0].holds


def test_an_interrupted_run_goes_on_where_it_stopped(checks: list[Stand], theory: Run, tmp_path: Path):
    checks[1].error = KeyboardInterrupt()
    status, _, errors = theory("--quick", out=tmp_path / "an out")
    assert status == 130
    assert errors == (
        "gsiirl: interrupted: finished checks are kept; "
        f"go on with `gsiirl theory --quick --out '{tmp_path / 'an out'}'`\n"
    )
    assert Findings.read(tmp_path / "an out").missing == ["Second", "Third"]
    assert not (tmp_path / "an out" / "index.html").exists()
    checks[1].error = None
    status, shown, _ = theory("--quick", out=tmp_path / "an out")
    assert status == 0
    assert "1/3 First: kept" in shown
    assert [len(check.calls) for check in checks] == [1, 2, 1]
    assert [each.title for each in Findings.read(tmp_path / "an out").findings] == ["First", "Second", "Third"]
    before = content_of(tmp_path / "an out")
    assert theory("--quick", out=tmp_path / "an out")[0] == 0
    assert [len(check.calls) for check in checks] == [1, 2, 1]
    assert content_of(tmp_path / "an out") == before


def test_a_fault_of_a_check_keeps_its_traceback_and_what_was_found(checks: list[Stand], theory: Run, tmp_path: Path):
    checks[2].error = ValueError("a fault")
    with pytest.raises(ValueError, match="a fault"):
        theory()
    assert [each.title for each in Findings.read(tmp_path / "out").findings] == ["First", "Second"]


def test_a_call_killed_in_its_first_write_can_be_repeated(checks: list[Stand], theory: Run, tmp_path: Path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "theory.json.aside").write_text("{")
    assert theory()[0] == 0


def test_several_findings_of_one_check_share_its_time(
    checks: list[Stand], theory: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def check(quick: bool) -> list[Finding]:
        time.sleep(0.1)
        return [Finding(key, key, "", "", "", [Measurement("number", 1.0)]) for key in ("one", "two")]

    monkeypatch.setattr(sys.modules["stand_in_First"], "check", check)
    assert theory()[0] == 0
    one, two = Findings.read(tmp_path / "out").findings[:2]
    assert (one.check, two.check) == ("First", "First")
    assert one.seconds == two.seconds >= 0.05


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda text: text[:-20], "theory.json: is damaged: no valid JSON"),
        (
            lambda text: text.replace('"measurements"', '"numbers"'),
            "theory.json: is damaged: findings.0.measurements: Field required",
        ),
        (lambda text: text.replace('"value": 0.5', '"value": "a lot"'), "theory.json: is damaged: findings.0.m"),
        (lambda text: text.replace('"spread": []', '"spread": [1.0]'), "theory.json: is damaged: findings.0.p"),
        (lambda text: text.replace('"quick": false', '"quick": true'), "was made with --quick; use another folder"),
        (lambda text: text.replace('"gsiirl": "', '"gsiirl": "9'), "holds findings of gsiirl 9"),
    ],
)
def test_findings_that_cannot_be_gone_on_with_are_left_alone(
    checks: list[Stand], theory: Run, tmp_path: Path, damage: Callable[[str], str], message: str
):
    checks[2].error = KeyboardInterrupt()
    assert theory()[0] == 130
    path = tmp_path / "out" / "theory.json"
    path.write_bytes(resealed(damage(path.read_text()).encode()))
    before = content_of(tmp_path / "out")
    status, shown, errors = theory()
    assert (status, shown) == (2, "")
    assert len(errors.splitlines()) == 1
    assert message in errors
    assert content_of(tmp_path / "out") == before
    assert [len(check.calls) for check in checks] == [1, 1, 1]


def test_a_folder_that_cannot_be_written_gets_one_line(checks: list[Stand], theory: Run, tmp_path: Path):
    (tmp_path / "file").write_text("mine")
    status, _, errors = theory(out=tmp_path / "file" / "below")
    assert status == 2
    assert len(errors.splitlines()) == 1
    assert checks[0].calls == []


def test_only_quick_checks_that_time_nothing_are_compiled_carelessly(
    checks: list[Stand], theory: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    seen: list[tuple[bool, bool, object]] = []

    def check(quick: bool) -> Finding:
        seen.append((quick, jax.config.read("jax_disable_most_optimizations"), jnp.ones(()).dtype))
        return Finding("key", "Title", "", "", "", [])

    for stand in checks:
        monkeypatch.setattr(sys.modules[f"stand_in_{stand.name}"], "check", check)
    first, second, third = [*run.CHECKS]
    monkeypatch.setattr(run, "CHECKS", (first, Check(second.module, second.title, timed=True), third))
    before = jax.config.read("jax_disable_most_optimizations")
    theory("--quick")
    theory(out=tmp_path / "full")
    double = jnp.dtype("float64")
    assert seen == [
        *((True, careless, double) for careless in (True, False, True)),
        *((False, before, double) for _ in range(3)),
    ]
    assert jax.config.read("jax_disable_most_optimizations") == before
