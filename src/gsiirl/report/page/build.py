"""Builds a report: reads the folders, draws, and writes the files."""

from dataclasses import dataclass
from pathlib import Path

from gsiirl.errors import InputError
from gsiirl.program.command import command
from gsiirl.report.figures.style import figure_style
from gsiirl.report.output.writing import write_files
from gsiirl.report.page.game_figures import draw_figures, network_of
from gsiirl.report.page.out_folder import TABLE, refuse_foreign_files, refuse_run_folder
from gsiirl.report.page.report import Report, Section
from gsiirl.report.read.group import GameGroup, group_runs
from gsiirl.report.read.run import ReportedRun
from gsiirl.report.tables.comparison import compare
from gsiirl.report.tables.quality import judge
from gsiirl.report.tables.rivals import rivals_of
from gsiirl.report.theory.part import TheoryPart
from gsiirl.runs import Findings
from gsiirl.runs.files.json_file import encode_json

PAGE, MARKDOWN = "index.html", "table.md"


@dataclass(frozen=True)
class ReportFiles:
    """Paths of the files of a report."""

    page: Path
    table_markdown: Path
    table_json: Path
    figures: list[Path]


def build_report(run_paths: list[Path], out: Path) -> ReportFiles:
    """Compare runs and show findings: write `index.html`, `table.md`, `table.json` and `figures/` into `out`.

    An earlier report in `out` is overwritten, any other file left alone.

    Raises:
        InputError: no folder is given, one holds neither a run nor findings, or `out` belongs to something else;
            nothing is written.
    """
    groups, measured = _read(run_paths)
    refuse_run_folder(out)
    report = _draw(groups, measured)
    figures = report.figure_files
    files = [TABLE, *figures, MARKDOWN, PAGE]
    refuse_foreign_files(out, files)
    # The table comes first: it lists the files, so that those of a report cut short are known as its own.
    contents = {TABLE: encode_json(TABLE, report.json(files)), **figures}
    write_files(out, contents | {MARKDOWN: report.markdown().encode(), PAGE: report.html().encode()})
    return ReportFiles(out / PAGE, out / MARKDOWN, out / TABLE, [out / name for name in figures])


def _read(run_paths: list[Path]) -> tuple[list[GameGroup], list[Findings]]:
    """The runs by game and the findings in the folders, each folder once."""
    if not run_paths:
        raise InputError("runs", "no run folder is given", "name at least one")
    paths = {path.resolve(): path for path in run_paths}.values()
    groups = group_runs([ReportedRun.read(path) for path in paths if not Findings.is_at(path)])
    return groups, [_read_findings(path) for path in paths if Findings.is_at(path)]


def _read_findings(path: Path) -> Findings:
    findings = Findings.read(path)
    if not findings.findings:
        raise InputError(str(path), "has no finished check yet", f"use {command('theory', '--out', path)} first")
    return findings


def _draw(groups: list[GameGroup], measured: list[Findings]) -> Report:
    with figure_style():
        sections = [
            Section(group, rivals_of(group), compare(group), judge(group), draw_figures(group), network_of(group))
            for group in groups
        ]
    names = [f"theory-{number}" for number in range(1, len(measured) + 1)]
    return Report(sections, [TheoryPart.of(each, name, f"{name}-") for each, name in zip(measured, names, strict=True)])
