"""Runs and a report of the two games in the plane, made once for all tests."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from report.synthetic import write_run
from report.synthetic_plane import write_plane_comparison

from gsiirl.report import ReportFiles, build_report
from gsiirl.report.curves import charts, point_charts
from gsiirl.report.figures import animation, page_figure


@pytest.fixture(scope="session", autouse=True)
def _without_charts() -> Iterator[None]:
    """Pages are made as without the extra `interactive`; the tests of charts undo that."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        for module in (charts, point_charts):
            monkeypatch.setattr(module, "charts_installed", lambda: False)
        yield


@pytest.fixture(scope="session")
def plane_runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Path]]:
    """Run folders by experiment; in the crossing, seed 1 of gsiirl has failed."""
    folder = tmp_path_factory.mktemp("runs")
    return {
        "crossing": write_plane_comparison(folder / "crossing", "crossing", failed_seed=1),
        "deception": write_plane_comparison(folder / "deception", "deception"),
        "security": [write_run(folder / "security", "gsiirl").path],
    }


def _undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page_figure, "figure_files", lambda figure: {"png": b"\x89PNG", "svg": b"<svg/>"})
    monkeypatch.setattr(animation, "_pixels", lambda figure: np.zeros((2, 2), np.uint32))


@pytest.fixture(scope="session")
def plane_report(plane_runs: dict[str, list[Path]], tmp_path_factory: pytest.TempPathFactory) -> ReportFiles:
    """The report of all of them, whose figures are made and not rendered."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        _undrawn(monkeypatch)
        return build_report([path for paths in plane_runs.values() for path in paths], tmp_path_factory.mktemp("out"))


@pytest.fixture(scope="session")
def drawn_plane_report(plane_runs: dict[str, list[Path]], tmp_path_factory: pytest.TempPathFactory) -> ReportFiles:
    """The same with everything rendered."""
    return build_report([path for paths in plane_runs.values() for path in paths], tmp_path_factory.mktemp("out"))


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made and not rendered: for tests of a page's words, most of whose time that would take."""
    _undrawn(monkeypatch)
