"""The table of quality has a row for each metric that a run has."""

from gsiirl.report import ReportFiles


def test_new_metrics_stand_in_the_table_of_quality(plane_report: ReportFiles) -> None:
    markdown = plane_report.table_markdown.read_text()
    for heading in ("collisions", "robot arrives", "human arrives", "error of the human's goal", "target preference"):
        assert f"| {heading} |" in markdown
    for heading in ("feature gap of sampling alone", "exploitability, learner"):
        assert markdown.count(f"| {heading} |") == 2
    assert "7.0 ± 0.0 %" in markdown
