"""The page that `gsiirl theory` writes beside its numbers."""

from pathlib import Path

from gsiirl.errors import InputError
from gsiirl.report.rendering import render
from gsiirl.report.theory_part import TheoryPart
from gsiirl.runs.atomic import write_atomically
from gsiirl.runs.findings import Findings

PAGE = "index.html"


def write_theory_page(findings: Findings, folder: Path) -> Path:
    """Write `index.html` and `figures/` into the folder of `theory.json`; returns the page's path.

    Raises:
        InputError: `folder` cannot be written.
    """
    part = TheoryPart.of(findings, "theory", "")
    contents = {name: content for figure in part.figures for name, content in figure.files.items()}
    contents[PAGE] = render("theory.html", generator="gsiirl theory", theory=part).encode()
    try:
        for name, content in contents.items():
            write_atomically(folder / name, content)
    except OSError as error:
        raise InputError("--out", f"{folder} cannot be written ({error.strerror})", "use another folder") from error
    return folder / PAGE
