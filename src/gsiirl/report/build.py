"""From folders of runs and of findings to a report folder."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gsiirl.errors import InputError
from gsiirl.report.comparison_table import RETURNS_NOTE, compare
from gsiirl.report.figure_style import figure_style
from gsiirl.report.figures import draw_figures
from gsiirl.report.group import group_runs
from gsiirl.report.page import GENERATOR, Section, render_markdown, render_page
from gsiirl.report.quality_table import judge
from gsiirl.report.run import ReportedRun
from gsiirl.report.table_1 import Table1
from gsiirl.report.theory_part import TheoryPart
from gsiirl.report.verdict import verdicts
from gsiirl.runs import Findings, RunFolder
from gsiirl.runs.atomic import write_atomically
from gsiirl.runs.json_file import encode_json, versioned

PAGE, MARKDOWN, TABLE = "index.html", "table.md", "table.json"


@dataclass(frozen=True)
class ReportFiles:
    """Where a report was written."""

    page: Path
    table_markdown: Path
    table_json: Path
    figures: list[Path]


def build_report(run_paths: list[Path], out: Path) -> ReportFiles:
    """Compare runs, show findings: write `index.html`, `table.md`, `table.json` and `figures/` under `out`.

    An earlier report in `out` is overwritten, any other file left alone.

    Raises:
        InputError: no folder, one that holds neither a run nor findings, or an `out` that belongs to something else;
            nothing is written.
    """
    if not run_paths:
        raise InputError("runs", "no run folder is given", "name at least one")
    paths = _distinct(run_paths)
    groups = group_runs([ReportedRun.read(path) for path in paths if not Findings.is_at(path)])
    measured = [_measured(path) for path in paths if Findings.is_at(path)]
    _refuse_run_folder(out)
    with figure_style():
        sections = [
            Section(group, verdicts(group), compare(group), judge(group), draw_figures(group)) for group in groups
        ]
    theories = [
        TheoryPart.of(findings, f"theory-{number}", f"theory-{number}-")
        for number, findings in enumerate(measured, start=1)
    ]
    table_1 = Table1.of([(section.group, section.comparison) for section in sections])
    parts: list[Section | TheoryPart] = [*sections, *theories]
    contents = {name: content for part in parts for figure in part.figures for name, content in figure.files.items()}
    contents[MARKDOWN] = render_markdown(sections, table_1, theories).encode()
    contents[PAGE] = render_page(sections, table_1, theories).encode()
    table = encode_json(TABLE, _table(sections, table_1, measured, [TABLE, *contents]))
    _refuse_foreign_files(out, [TABLE, *contents])
    try:
        # First what lists the files: a report cut short can then be told from files of the user's.
        for name, content in {TABLE: table, **contents}.items():
            write_atomically(out / name, content)
    except OSError as error:
        raise InputError("--out", f"{out} cannot be written ({error.strerror})", "use another folder") from error
    figures = [out / name for name in contents if name.startswith("figures/")]
    return ReportFiles(out / PAGE, out / MARKDOWN, out / TABLE, figures)


def _measured(path: Path) -> Findings:
    findings = Findings.read(path)
    if not findings.findings:
        raise InputError(str(path), "has no finished check yet", f"use gsiirl theory --out {path} first")
    return findings


def _table(
    sections: list[Section], table_1: Table1 | None, measured: list[Findings], files: list[str]
) -> dict[str, Any]:
    groups = [
        {
            "experiment": section.group.experiment,
            "game": section.group.game.get("name"),
            "variant": section.group.game.get("variant"),
            "verdicts": section.verdicts,
            "returns": [row.json() for row in section.comparison],
            "quality": [row.json() for row in section.quality],
        }
        for section in sections
    ]
    notes = dict.fromkeys(section.paper_note for section in sections if section.paper_note)
    return versioned(
        {
            "generator": GENERATOR,
            "files": files,
            "notes": [RETURNS_NOTE, *notes],
            **({"table_1": table_1.json()} if table_1 else {}),
            "groups": groups,
            "theory": [findings.json() for findings in measured],
        }
    )


def _distinct(paths: list[Path]) -> list[Path]:
    return list({path.resolve(): path for path in paths}.values())


def _refuse_run_folder(out: Path) -> None:
    for folder in (out.resolve(), *out.resolve().parents):
        for kind, found in (("run", RunFolder.is_at(folder)), ("theory", Findings.is_at(folder))):
            if found:
                raise InputError(
                    "--out", f"{out} is in the {kind} folder {folder}", "use another folder for the report"
                )


def _refuse_foreign_files(out: Path, files: list[str]) -> None:
    if out.exists() and not out.is_dir():
        raise InputError("--out", f"{out} is a file", "use another folder")
    own = _files_of_earlier_report(out)
    foreign = [name for name in files if name not in own and (out / name).exists()]
    if foreign:
        problem = f"{out} holds {', '.join(foreign)}, not written by gsiirl report"
        raise InputError("--out", problem, "use another folder or move them away")


def _files_of_earlier_report(out: Path) -> list[str]:
    try:
        table = json.loads((out / TABLE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return []
    if not isinstance(table, dict) or table.get("generator") != GENERATOR:
        return []
    return [str(name) for name in table.get("files", [])]
