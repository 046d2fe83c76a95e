"""The page of the findings shows every number, every bound and what was missed."""

import html
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from report.structure import faults
from report.synthetic import write_run
from report.synthetic_theory import all_findings, missed, power_law

from gsiirl.errors import InputError
from gsiirl.report import build_report, write_theory_page
from gsiirl.report.theory.part import TheoryPart
from gsiirl.runs import Findings
from gsiirl.runs.measurement_words import bound_in_words, value_in_words


def content_of(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def section_of(page: str, anchor: str) -> str:
    """A section's text without marks, its white space made single."""
    (found,) = re.findall(rf'<section id="{anchor}".*?</section>', page, re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", found)).split())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of `gsiirl theory` with made-up findings."""
    out = tmp_path_factory.mktemp("theory")
    findings = all_findings()
    findings.write(out)
    write_theory_page(findings, out)
    return out


@pytest.fixture(scope="module")
def page(folder: Path) -> str:
    return (folder / "index.html").read_text()


def test_every_measurement_stands_with_its_bound_and_verdict(page: str):
    for finding in all_findings().findings:
        text = section_of(page, f"theory-{finding.key}")
        assert finding.title in text
        assert finding.claim in text
        assert finding.printed in text
        assert finding.reading in text
        for each in finding.measurements:
            verdict = {True: "holds", False: "missed", None: ""}[each.holds]
            row = [each.name, value_in_words(each), bound_in_words(each), verdict]
            assert " ".join(filter(None, row)) in text


def test_a_missed_bound_is_told_at_once(page: str):
    summary = section_of(page, "theory")
    assert "falls at every iteration. 0 of 1 missed 12.0" in summary
    assert "Lemma 2: Hypergradient by finite differences" in summary
    assert "& its variance with 1/N. 2 of 2 holds 3.2" in summary
    assert "2 of 4 bounds hold; missed in The leader" in page
    assert "Not run yet: Lemma 6" in page
    assert "quick mode" in page


@pytest.mark.usefixtures("undrawn")
def test_findings_that_hold_are_not_called_missed(tmp_path: Path):
    page = write_theory_page(Findings(False, [power_law()]), tmp_path).read_text()
    assert "All 2 bounds hold." in page
    assert '<span class="badge missed">' not in page
    assert "quick mode" not in page


def test_the_page_needs_nothing_but_itself(folder: Path, page: str):
    assert "<script" not in page
    assert "http" not in page.replace("http://www.w3.org", "")
    sources = re.findall(r'src="([^"]*)"', page)
    assert len(sources) == len(list(folder.glob("figures/*.svg"))) == 3
    assert all(source.startswith("data:image/svg+xml,") for source in sources)
    for link in re.findall(r'href="#([^"]*)"', page):
        assert f'id="{link}"' in page


@pytest.mark.usefixtures("undrawn")
def test_the_page_can_be_read_by_all(page: str, folder: Path, tmp_path: Path):
    assert faults(page) == []
    write_run(tmp_path / "run", "marl", seeds=1, iterations=1)
    assert faults(build_report([folder, tmp_path / "run", folder], tmp_path / "out").page.read_text()) == []
    assert faults(build_report([folder], tmp_path / "alone").page.read_text()) == []


@pytest.mark.slow
def test_the_same_findings_give_the_same_bytes(folder: Path, tmp_path: Path):
    findings = Findings.read(folder)
    findings.write(tmp_path)
    write_theory_page(findings, tmp_path)
    assert content_of(tmp_path) == content_of(folder)


@pytest.mark.usefixtures("undrawn")
def test_words_of_the_findings_are_text_and_nothing_else(tmp_path: Path):
    finding = replace(missed(), claim="<script>alert(1)</script>", title="a < b")
    page = write_theory_page(Findings(False, [finding]), tmp_path).read_text()
    assert "<script" not in page
    assert "&lt;script&gt;" in page


@pytest.mark.parametrize(
    ("missing", "verdict"),
    [
        ([], "All 2 bounds hold."),
        (["Lemma 6"], "All 2 bounds measured so far hold; not every check was run."),
    ],
)
@pytest.mark.usefixtures("undrawn")
def test_all_bounds_hold_only_where_every_check_was_run(missing: list[str], verdict: str):
    part = TheoryPart.of(Findings(False, [power_law()], missing=missing), "theory", "")
    assert part.verdict == verdict


def test_how_the_theory_was_measured_is_told(folder: Path):
    page = section_of((folder / "index.html").read_text(), "made")
    assert "gsiirl theory --quick --out theory, not recorded, by gsiirl 0.0, jax 0.0" in page
    part = TheoryPart(Findings(False, [], {"gsiirl": "0.0", "date": "2026-01-31"}), "theory", [])
    assert "gsiirl theory --out theory, 2026-01-31, by gsiirl 0.0;" in part.made


@pytest.mark.usefixtures("undrawn")
def test_a_finding_without_panels_has_its_table_alone(tmp_path: Path):
    page = write_theory_page(Findings(False, [replace(missed(), panels=[])]), tmp_path).read_text()
    assert "<img" not in page
    assert "largest ratio of two distances 1.00001 at most 1 missed" in section_of(page, "theory-theorem-1")
    assert set(content_of(tmp_path)) == {"index.html"}


@pytest.mark.usefixtures("undrawn")
def test_a_report_takes_findings_alone(folder: Path, tmp_path: Path):
    files = build_report([folder], tmp_path / "out")
    page, table = files.page.read_text(), files.table_markdown.read_text()
    assert page.count("<h1>") == 1
    assert "The theory, measured" in page
    assert {path.stem for path in files.figures} == {f"theory-1-{each.key}" for each in all_findings().findings}
    assert "largest ratio of two distances 1.00001 at most 1 missed" in section_of(page, "theory-1-theorem-1")
    assert "| largest ratio of two distances | 1.00001 | at most 1 | MISSED |" in table
    content = json.loads(files.table_json.read_text())
    assert content["theory"] == [Findings.read(folder).json()]
    assert sorted(content["files"]) == sorted(content_of(files.page.parent))


@pytest.mark.usefixtures("undrawn")
def test_a_report_shows_runs_and_then_findings(folder: Path, tmp_path: Path):
    write_run(tmp_path / "run", "marl", seeds=1, iterations=1)
    page = build_report([folder, tmp_path / "run", folder], tmp_path / "out").page.read_text()
    assert page.count("The theory, measured</h2>") == 1
    assert page.index("Final returns") < page.index("The theory, measured</h2>")


@pytest.mark.usefixtures("undrawn")
def test_two_folders_of_findings_have_their_own_figures(folder: Path, tmp_path: Path):
    Findings(False, [missed()]).write(tmp_path / "full")
    files = build_report([folder, tmp_path / "full"], tmp_path / "out")
    assert "theory-2-theorem-1" in {path.stem for path in files.figures}
    ids = re.findall(r'id="([^"]*)"', files.page.read_text())
    assert len(ids) == len(set(ids))


@pytest.mark.usefixtures("undrawn")
def test_a_report_leaves_the_folder_of_the_theory_alone(folder: Path, tmp_path: Path):
    before = content_of(folder)
    with pytest.raises(InputError, match="is in the theory folder"):
        build_report([folder], folder / "report")
    assert content_of(folder) == before


def test_findings_that_cannot_be_shown_get_one_line(tmp_path: Path):
    Findings(False, [], missing=["Lemma 2"]).write(tmp_path / "early")
    with pytest.raises(InputError, match=r"no finished check yet; use gsiirl theory --out"):
        build_report([tmp_path / "early"], tmp_path / "out")
    (tmp_path / "early" / "theory.json").write_text("{")
    with pytest.raises(InputError, match=r"theory.json: is damaged"):
        build_report([tmp_path / "early"], tmp_path / "out")
    assert not (tmp_path / "out").exists()
