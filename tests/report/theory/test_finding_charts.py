"""The charts of a finding hold what its drawing holds."""

import csv
import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from report.synthetic_theory import curve, many_panels, power_law

from gsiirl.report.curves import point_charts
from gsiirl.report.figures.charts import Charts
from gsiirl.report.theory.finding_charts import finding_charts
from gsiirl.runs import Curve, Finding, Panel

pytest.importorskip("altair")


@pytest.fixture(autouse=True)
def _with_charts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(point_charts, "charts_installed", lambda: True)


def charts_of(finding: Finding) -> Charts:
    found = finding_charts(finding)
    assert found is not None
    return found


def rows_of(specification: str) -> list[dict[str, Any]]:
    """The table that a chart carries."""
    (text,) = json.loads(specification)["datasets"].values()
    return list(csv.DictReader(text.splitlines()))


def test_every_point_of_every_curve_is_in_the_chart() -> None:
    finding = power_law()
    for chart, panel in zip(charts_of(finding).panels, finding.panels, strict=True):
        rows = rows_of(chart.specification)
        for each in panel.curves:
            mine = [row for row in rows if row["run"] == each.name]
            np.testing.assert_allclose([float(row["x"]) for row in mine], each.x)
            np.testing.assert_allclose([float(row["y"]) for row in mine], each.y)
            spread = each.spread or [0.0] * len(each.y)
            np.testing.assert_allclose([float(row["high"]) for row in mine], np.add(each.y, spread))


def test_slopes_stand_under_the_title() -> None:
    first, _ = charts_of(power_law()).panels
    assert "two-sided differences, response measured at both ends 2.00" in first.meaning


def test_what_cannot_be_drawn_is_left_out() -> None:
    line = curve("falls to nothing", np.array([1.0, 2.0, 3.0, np.inf]), np.array([1.0, 0.0, np.nan, 1.0]))
    finding = Finding("key", "title", "claim", "", "", [], [Panel("panel", "x", "y", [line])])
    (chart,) = charts_of(finding).panels
    assert [float(row["y"]) for row in rows_of(chart.specification)] == [1.0]


def test_a_spread_without_numbers_is_no_obstacle() -> None:
    line = Curve("one", [1.0, 2.0], [1.0, 2.0], [np.inf, np.inf])
    panel = Panel("panel", "x", "y", [line], log_x=False, log_y=False)
    (chart,) = charts_of(Finding("key", "title", "claim", "", "", [], [panel])).panels
    assert [float(row["y"]) for row in rows_of(chart.specification)] == [1.0, 2.0]


def test_a_curve_has_the_colour_of_the_drawing_in_all_panels() -> None:
    keys = charts_of(many_panels()).runs
    assert len({each.colour for each in keys}) == len(keys)


def test_a_finding_without_figure_has_no_charts() -> None:
    assert finding_charts(replace(power_law(), panels=[])) is None
