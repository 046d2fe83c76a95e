"""Charts hold what the drawings hold, seed by seed."""

import json
from pathlib import Path

import numpy as np
import polars
import pytest
from report.synthetic import group_of, write_comparison

from gsiirl.report.curves import charts
from gsiirl.report.curves.charts import charts_of, panel_table
from gsiirl.report.curves.returns_figure import returns_levels, returns_panels
from gsiirl.report.figures.charts import Charts
from gsiirl.report.read.group import GameGroup

pytest.importorskip("altair")
vl_convert = pytest.importorskip("vl_convert")


@pytest.fixture(scope="module")
def group(tmp_path_factory: pytest.TempPathFactory) -> GameGroup:
    return group_of(write_comparison(tmp_path_factory.mktemp("runs"), failed_seed=2))


@pytest.fixture(scope="module")
def made(group: GameGroup) -> Charts:
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(charts, "charts_installed", lambda: True)
        found = charts_of(group, returns_panels(group), returns_levels(group))
    assert found is not None
    return found


def curves_of(specification: str, **shown: list) -> int:
    """The number of curves, thick and thin, that Vega draws with these values of the parameters."""
    content = json.loads(specification)
    for parameter in content["params"]:
        if parameter["name"] in shown:
            parameter["value"] = shown[parameter["name"]]
    drawn = vl_convert.vegalite_to_svg(content | {"width": 300})
    return sum(part.split("</g>")[0].count("<path") for part in drawn.split('class="mark-line')[1:])


def test_a_chart_holds_every_kept_seed_and_the_means_are_those_of_the_drawing(group: GameGroup) -> None:
    table = panel_table(group, "deployed_return_learner")
    for label, seeds in (("MA-IRL", {0, 1, 2}), ("GSIIRL", {0, 1})):
        curve, rows = group.runs[label].curve("deployed_return_learner"), table.filter(polars.col("run") == label)
        assert curve is not None
        assert set(rows["seed"]) == seeds
        means = rows.group_by("iteration").agg(polars.col("value").mean()).sort("iteration")["value"]
        np.testing.assert_allclose(means.to_numpy(), curve.mean, rtol=1e-5)


def test_charts_have_the_panels_levels_and_seeds_of_the_drawing(group: GameGroup, made: Charts) -> None:
    assert [(each.title, each.meaning) for each in made.panels] == [
        (panel.title, panel.meaning) for panel in returns_panels(group)
    ]
    assert [each.label for each in made.levels] == [each.label for each in returns_levels(group)]
    assert ([each.label for each in made.runs], made.seeds) == (["MA-IRL", "GSIIRL"], [0, 1, 2])


def test_a_seed_or_a_run_that_is_switched_off_has_no_curve(made: Charts) -> None:
    specification = made.panels[0].specification
    assert curves_of(specification) == 2 + 3 + 2
    assert curves_of(specification, seeds=[0, 1]) == 2 + 2 + 2
    assert curves_of(specification, runs=["MA-IRL"]) == 1 + 3
    assert curves_of(specification, seeds=[]) == 0


def test_a_long_run_is_thinned_and_keeps_both_ends(group: GameGroup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(charts, "MOST_ROWS", 40)
    table = panel_table(group, "deployed_return_learner").filter(run="GSIIRL", seed=0)
    assert table["iteration"].to_list() == [0, 3, 6, 9, 12, 15, 18, 20]


def test_a_runs_name_stands_in_a_chart_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(charts, "charts_installed", lambda: True)
    (path, *_) = write_comparison(tmp_path)
    named = group_of([path])
    labelled = GameGroup(named.key, {"</script>": next(iter(named.runs.values()))})
    found = charts_of(labelled, returns_panels(labelled), [])
    assert found is not None
    (runs,) = [each for each in json.loads(found.panels[0].specification)["params"] if each["name"] == "runs"]
    assert runs["value"] == ["</script>"]


def test_without_the_extra_there_are_no_charts(group: GameGroup) -> None:
    assert charts_of(group, returns_panels(group), []) is None


def test_a_metric_without_a_number_leaves_an_empty_panel(group: GameGroup, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(charts, "charts_installed", lambda: True)
    whole = panel_table
    monkeypatch.setattr(charts, "panel_table", lambda group, metric: whole(group, metric).clear())
    assert charts_of(group, returns_panels(group), []) is not None
