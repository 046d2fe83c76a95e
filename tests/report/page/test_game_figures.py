"""Each game has its figures, with captions that say what is left out."""

from pathlib import Path

import pytest
from report.synthetic import group_of

from gsiirl.report import ReportFiles
from gsiirl.report.page.game_figures import draw_figures

ONE_GAME = {
    "crossing": ["reward-map", "animation", "returns", "rates", "path"],
    "deception": ["weights", "animation", "returns", "path"],
}


def test_each_game_has_its_figures(plane_report: ReportFiles) -> None:
    names = list(dict.fromkeys(path.stem for path in plane_report.figures))
    for number, experiment in enumerate(("crossing", "deception"), start=1):
        assert [name for name in names if name.startswith(f"game-{number}-")] == [
            f"game-{number}-{name}" for name in ONE_GAME[experiment]
        ]


@pytest.mark.usefixtures("undrawn")
def test_captions_of_what_was_lived_through_say_who_explores(plane_runs: dict[str, list[Path]]) -> None:
    told = {
        experiment: {
            figure.name
            for figure in draw_figures(group_of(plane_runs[experiment]))
            if "Encounters that GSIIRL plays to see more, not to earn, are left out." in figure.caption
        }
        for experiment in ("crossing", "deception")
    }
    assert told == {"crossing": {"game-1-returns", "game-1-rates"}, "deception": {"game-1-returns"}}
