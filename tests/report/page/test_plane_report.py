"""Reports of the crossing and of deception, alone and beside each other."""

import json
import re
from pathlib import Path

import numpy as np
import polars
import pytest
from report.synthetic import group_of

from gsiirl.report import ReportFiles, build_report
from gsiirl.runs import RunFolder


def table_of(files: ReportFiles) -> dict:
    return json.loads(files.table_json.read_text())


@pytest.mark.slow
def test_the_same_runs_give_the_same_bytes(
    plane_runs: dict[str, list[Path]], drawn_plane_report: ReportFiles, tmp_path: Path
) -> None:
    again = build_report(
        [*plane_runs["crossing"], *plane_runs["deception"], *plane_runs["security"]], tmp_path / "again"
    )
    for first, second in zip(drawn_plane_report.figures, again.figures, strict=True):
        assert first.read_bytes() == second.read_bytes(), first.name
    assert drawn_plane_report.page.read_bytes() == again.page.read_bytes()


def test_the_page_needs_nothing_but_itself_and_names_the_sides(plane_report: ReportFiles) -> None:
    page = plane_report.page.read_text()
    assert "http" not in page
    assert all(source.startswith("data:image/") for source in re.findall(r'src="([^"]*)"', page))
    assert "(here a robot, or two agents that hide their target, or the defender of a network)" in page
    for heading in ("robot (learner)", "human (expert)", "good agents (learner)", "adversary (expert)"):
        assert heading in page


def test_a_failed_seed_is_named_and_left_out_everywhere(
    plane_runs: dict[str, list[Path]], plane_report: ReportFiles
) -> None:
    crossing = table_of(plane_report)["groups"][0]
    (quality,) = [row for row in crossing["quality"] if row["algorithm"] == "gsiirl"]
    assert quality["failed_seeds"] == [1]
    assert quality["human_goal_error"]["count"] == 2
    assert "1 of 3 seeds of GSIIRL failed (seed 1)" in plane_report.page.read_text()
    run = group_of(plane_runs["crossing"]).runs["GSIIRL"]
    for metric in ("collision_rate", "goal_rate_robot", "deployed_return_learner"):
        curve = run.curve(metric)
        assert curve is not None
        kept = RunFolder.open(run.path).metrics().filter(polars.col("seed") != 1, polars.col("exploring") == 0)
        means = kept.group_by("iteration").agg(polars.col(metric).mean()).sort("iteration")[metric]
        np.testing.assert_allclose(curve.mean, means.to_numpy())
