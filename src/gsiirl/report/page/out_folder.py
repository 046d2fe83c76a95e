"""Where a report may be written."""

import json
from pathlib import Path

from gsiirl.errors import InputError
from gsiirl.report.page.report import GENERATOR
from gsiirl.runs import Findings, RunFolder

TABLE = "table.json"
"""The file that names the files of a report."""


def refuse_run_folder(out: Path) -> None:
    """Refuse a folder that is, or lies in, the folder of a run or of the theory.

    Raises:
        InputError: it does.
    """
    for folder in (out.resolve(), *out.resolve().parents):
        for kind, found in (("run", RunFolder.is_at(folder)), ("theory", Findings.is_at(folder))):
            if found:
                problem = f"{out} is in the {kind} folder {folder}"
                raise InputError("--out", problem, "use another folder for the report")


def refuse_foreign_files(out: Path, files: list[str]) -> None:
    """Refuse a folder in which a report of these files would overwrite files that are not an earlier report's.

    Raises:
        InputError: it would, or `out` is a file.
    """
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
