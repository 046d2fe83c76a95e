"""Deception has the figures that its files allow."""

from pathlib import Path

from report.synthetic import group_of
from report.synthetic_plane import write_plane_run
from resealing import rewrite

from gsiirl.report.deception.figures import deception_figures
from gsiirl.report.figures.style import figure_style


def test_deception_without_its_truth_or_paths_has_the_other_figures(tmp_path: Path) -> None:
    write_plane_run(tmp_path / "run", "deception", "gsiirl", variant="separate_target")
    rewrite(tmp_path / "run" / "game.json", '"truth"', '"lie"')
    rewrite(tmp_path / "run" / "summary.json", '"paths.parquet"', '"learned.json"')
    (tmp_path / "run" / "paths.parquet").unlink()
    group = group_of([tmp_path / "run"])
    with figure_style():
        figures = [figure for figure in deception_figures(group, group.of("gsiirl")) if figure]
    assert [figure.name for figure in figures] == ["game-1-weights"]
    assert "true" not in figures[0].caption
