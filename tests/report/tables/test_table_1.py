"""Table 1 stands on top, with the paper's results beside ours."""

import json
from pathlib import Path

import numpy as np
import pytest
from report.synthetic import SyntheticGame, dense_graph, write_run
from report.synthetic_plane import write_plane_run
from resealing import rewrite

from gsiirl.report import ReportFiles, build_report
from gsiirl.report.read.run import ReportedRun


def table_of(files: ReportFiles) -> dict:
    return json.loads(files.table_json.read_text())


def test_table_1_stands_on_top_with_the_papers_figures(plane_report: ReportFiles) -> None:
    table = table_of(plane_report)["table_1"]
    assert [column["column"] for column in table] == ["MPE", "HRI", "CS"]
    paper = {
        column["column"]: [
            (row["algorithm"], row["learner"]["paper"]["mean"])
            for row in column["returns"]
            if "paper" in row["learner"]
        ]
        for column in table
    }
    assert paper["MPE"] == [("marl", 5.43), ("ma-irl", 5.12), ("gsiirl", 4.54), ("paper", 4.54)]
    assert paper["HRI"] == [("marl", -20.22), ("ma-irl", -20.63), ("gsiirl", -21.69), ("paper", -21.69)]
    assert paper["CS"] == [("marl", -16.96), ("gsiirl", -17.38)]
    page, markdown = plane_report.page.read_text(), plane_report.table_markdown.read_text()
    assert page.index("Table 1") < page.index('<section id="game-1">')
    for text in (page, markdown.replace("'", "&#39;")):
        for printed in ("5.12 ± 4.08", "\N{MINUS SIGN}20.37 ± 4.27", "\N{MINUS SIGN}13.16 ± 1.03", "6.76 ± 3.59"):
            assert printed in text
        for sentence in (column["sentence"] for column in table):
            assert sentence.replace("'", "&#39;") in text


def test_the_gap_to_marl_is_that_of_the_seeds(plane_runs: dict[str, list[Path]], plane_report: ReportFiles) -> None:
    (column,) = [column for column in table_of(plane_report)["table_1"] if column["experiment"] == "deception"]
    (path,) = [path for path in plane_runs["deception"] if path.name == "gsiirl"]
    run = ReportedRun.read(path)
    marl = ReportedRun.read(path.parent / "marl")
    # Both deployed: not with the pair that MARL trained.
    difference = run.final["deployed_return_learner"] - marl.final["deployed_return_learner"]
    gap = column["gap_to_marl"]
    assert gap["difference"] == pytest.approx(difference.mean())
    assert gap["high"] - gap["difference"] == pytest.approx(4.30265273 * difference.std(ddof=1) / np.sqrt(3))
    assert gap["verdict"] == "cannot tell with 3 seeds"
    assert column["sentence"].endswith(": cannot tell with 3 seeds; the paper's GSIIRL ends 16 % below its MARL.")


@pytest.mark.usefixtures("undrawn")
def test_another_network_than_one_like_the_papers_stands_nowhere_beside_it(
    plane_runs: dict[str, list[Path]], tmp_path: Path
) -> None:
    write_run(tmp_path / "dense", "gsiirl", SyntheticGame(dense_graph()))
    own = write_run(tmp_path / "own", "gsiirl").path
    rewrite(own / "config.json", '"security"', '"security", "graph": "mine.json"')
    crossing = [path for path in plane_runs["crossing"] if path.name == "marl"]
    files = build_report([tmp_path / "dense", own, *crossing], tmp_path / "out")
    assert "table_1" not in table_of(files)
    for group in table_of(files)["groups"]:
        printed = [row["algorithm"] for row in group["returns"] if "paper" in row["learner"]]
        assert printed == (["marl"] if group["experiment"] == "crossing" else [])


@pytest.mark.usefixtures("undrawn")
def test_one_experiment_alone_has_no_table_1(plane_runs: dict[str, list[Path]], tmp_path: Path) -> None:
    files = build_report([path for path in plane_runs["crossing"] if path.name == "marl"], tmp_path / "out")
    assert "table_1" not in table_of(files)
    assert "(here a robot)" in files.page.read_text()


@pytest.mark.usefixtures("undrawn")
def test_of_two_games_table_1_shows_the_one_with_more_algorithms_and_says_so(
    plane_runs: dict[str, list[Path]], tmp_path: Path
) -> None:
    marl, gsiirl = (path for path in plane_runs["deception"] if path.name in ("marl", "gsiirl"))
    other = write_plane_run(tmp_path / "other", "deception", "marl", variant="separate_target")
    crossing = [path for path in plane_runs["crossing"] if path.name == "marl"]
    files = build_report([other.path, marl, gsiirl, *crossing], tmp_path / "out")
    column, _ = table_of(files)["table_1"]
    assert column["variant"] == "mpe"
    assert "MPE shows physical deception, mpe: of the 2 games below" in files.page.read_text()
