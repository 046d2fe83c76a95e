"""Where a report may be written."""

from pathlib import Path

from pydantic_core import from_json

from gsiirl.errors import InputError
from gsiirl.program.presence import is_folder, is_there
from gsiirl.report.page.report import GENERATOR
from gsiirl.runs import Findings, RunFolder
from gsiirl.runs.files.damage import refuse_unreadable

TABLE = "table.json"
"""The file that names the files of a report."""


def refuse_run_folder(out: Path) -> None:
    """Refuse a folder that is, or lies in, the folder of a run or of the theory.

    Raises:
        InputError: it does.
    """
    mend = "use another folder for the report"
    with refuse_unreadable("--out", out, mend):
        for folder in (out.resolve(), *out.resolve().parents):
            for kind, found in (("run", RunFolder.is_at(folder)), ("theory", Findings.is_at(folder))):
                if found:
                    raise InputError("--out", f"{out} is in the {kind} folder {folder}", mend)


def refuse_foreign_files(out: Path, files: list[str]) -> None:
    """Refuse a folder in which a report of these files would overwrite files that are not an earlier report's.

    Raises:
        InputError: it would, or `out` is a file.
    """
    with refuse_unreadable("--out", out, "use another folder"):
        if is_there(out) and not is_folder(out):
            raise InputError("--out", f"{out} is a file", "use another folder")
        own = _files_of_earlier_report(out)
        foreign = [name for name in files if name not in own and is_there(out / name)]
    if foreign:
        problem = f"{out} holds {', '.join(foreign)}, not written by gsiirl report"
        raise InputError("--out", problem, "use another folder or move them away")


def _files_of_earlier_report(out: Path) -> list[str]:
    try:
        table = from_json((out / TABLE).read_bytes())
    except (FileNotFoundError, ValueError):
        return []
    if not isinstance(table, dict) or table.get("generator") != GENERATOR:
        return []
    files = table.get("files")
    return [str(name) for name in files] if isinstance(files, list) else []
