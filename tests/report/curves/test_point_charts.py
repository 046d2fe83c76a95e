"""Charts of measured points hold every point with its words, and can be switched curve by curve."""

import html
import json

import polars
import pytest

from gsiirl.report.curves import point_charts as module
from gsiirl.report.curves.point_charts import PointAxis, PointCurve, PointPanel, point_charts
from gsiirl.report.figures.charts import Charts

pytest.importorskip("altair")
vl_convert = pytest.importorskip("vl_convert")


@pytest.fixture(autouse=True)
def _with_charts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "charts_installed", lambda: True)


def curve(name: str, heights: list[float], shape: str = "circle") -> PointCurve:
    table = polars.DataFrame({"x": [float(each + 1) for each in range(len(heights))], "y": heights})
    table = table.with_columns(low=polars.col("y") * 0.5, high=polars.col("y") * 2)
    words = [
        polars.lit("step ") + polars.col("x").cast(int).cast(str),
        polars.lit("about ") + polars.col("y").cast(str),
    ]
    return PointCurve(name, table.with_columns(at=words[0], told=words[1]), "#123456", shape=shape)


def panel(*curves: PointCurve, bars: bool = False, words: tuple[str, ...] = ()) -> PointPanel:
    x = PointAxis("steps", ticks=tuple(enumerate(words, 1)))
    y = PointAxis("error", logarithmic=True, limits=(1e-9, 10.0))
    return PointPanel("Errors", "", x, y, list(curves), bars=bars)


def made(*panels: PointPanel) -> Charts:
    found = point_charts(list(panels))
    assert found is not None
    return found


def drawn(specification: str, **parameters: list) -> dict[str, int]:
    """How many marks of each kind Vega draws with these values of the parameters."""
    content = json.loads(specification)
    for parameter in content["params"]:
        if parameter["name"] in parameters:
            parameter["value"] = parameters[parameter["name"]]
    parts = vl_convert.vegalite_to_svg(content | {"width": 300}).split('class="mark-')[1:]
    counts: dict[str, int] = {}
    for part in parts:
        kind, inside = part.split(" ", 1)[0], part.split("</g>")[0]
        if 'aria-roledescription="axis"' not in inside:
            counts[kind] = counts.get(kind, 0) + inside.count("<path") + inside.count("<line")
    return counts


def test_every_curve_has_its_line_its_points_and_its_band() -> None:
    marks = drawn(made(panel(curve("one", [1e-3, 1e-6]), curve("other", [1.0, 2.0, 3.0]))).panels[0].specification)
    assert (marks["line"], marks["area"]) == (2, 2)
    assert marks["symbol"] == 2 * (2 + 3)  # and once more those, unseen, that the pointer finds


def test_a_curve_of_many_points_has_no_marks_but_tells_its_values() -> None:
    marks = drawn(made(panel(curve("one", [1.0, 2.0, 3.0], shape=""))).panels[0].specification)
    assert marks["symbol"] == 3


def test_a_curve_that_is_switched_off_is_not_drawn() -> None:
    specification = made(panel(curve("one", [1.0, 2.0]), curve("other", [1.0, 2.0]))).panels[0].specification
    assert drawn(specification, runs=["other"])["line"] == 1
    assert "line" not in drawn(specification, runs=[])


def test_intervals_are_bars_and_places_have_words() -> None:
    (found,) = made(panel(curve("one", [1.0, 2.0]), bars=True, words=('the "first"', "second"))).panels
    assert "area" not in drawn(found.specification)
    picture = vl_convert.vegalite_to_svg(json.loads(found.specification) | {"width": 300})
    assert 'the "first"' in html.unescape(picture)


def test_the_words_of_every_point_are_in_the_chart() -> None:
    (found,) = made(panel(curve("one", [0.25, 0.5]))).panels
    (text,) = json.loads(found.specification)["datasets"].values()
    assert "step 2" in text
    assert "about 0.5" in text


def test_curves_of_one_name_are_one_switch_for_all_panels() -> None:
    found = made(panel(curve("one", [1.0])), panel(curve("one", [2.0]), curve("other", [1.0])))
    assert ([each.label for each in found.runs], found.seeds) == (["one", "other"], [])


def test_a_panel_without_points_leaves_the_drawing_in_its_place() -> None:
    assert point_charts([panel(curve("one", [1.0])), panel(curve("none", []))]) is None
    assert point_charts([]) is None


def test_without_the_extra_there_are_no_charts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "charts_installed", lambda: False)
    assert point_charts([panel(curve("one", [1.0]))]) is None
