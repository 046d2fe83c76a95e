"""A report can be read with a keyboard, a screen reader and a phone, and loads nothing."""

from pathlib import Path

import pytest
from report.structure import Page, faults
from report.synthetic import write_comparison

from gsiirl.report import ReportFiles, build_report
from gsiirl.report.curves import charts
from gsiirl.report.figures import page_figure
from gsiirl.report.output import chart_program
from gsiirl.report.output.rendering import packed

BOX = '<div class="wide" role="group" tabindex="0" aria-label="Numbers">'
SOUND = (
    '<nav><a href="#part">Part</a></nav><h1>All</h1><section id="part"><h2>Part</h2>'
    f'{BOX}<table><tr><td></td><th scope="col">mean</th></tr></table></div>'
    '<img src="data:image/png," alt="a line"></section>'
)


@pytest.fixture(scope="module")
def security(tmp_path_factory: pytest.TempPathFactory) -> str:
    """One game, with charts; their program is a word."""
    folder = tmp_path_factory.mktemp("security")
    pytest.importorskip("altair")
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setattr(charts, "charts_installed", lambda: True)
        monkeypatch.setattr(chart_program, "chart_program", lambda: "program")
        monkeypatch.setattr(page_figure, "figure_files", lambda figure: {"svg": b"<svg/>"})
        return build_report(write_comparison(folder / "runs"), folder / "out").page.read_text()


def test_a_page_of_three_games_has_no_fault(plane_report: ReportFiles) -> None:
    assert faults(plane_report.page.read_text()) == []


def test_a_page_of_one_game_with_charts_has_no_fault(security: str) -> None:
    assert faults(security) == []


@pytest.mark.parametrize(
    ("part", "broken", "fault"),
    [
        ('scope="col"', "", "header of a table"),
        (">mean<", "><", "header of a table"),
        ('alt="a line"', "", "without words"),
        ("data:image/png,", "data:image/gif,", "moves by itself"),
        ("data:image/png,", "https://example.org/a.png", "is loaded"),
        ("<h2>Part</h2>", "<h3>Part</h3>", "heading 3 after 1"),
        ('href="#part"', 'href="#other"', "link to nowhere"),
        ('href="#part"', 'href="#other"', "contents lack: part"),
        ('tabindex="0"', "", "no key scrolls it"),
        (BOX, "<div>", "widens the page"),
    ],
)
def test_a_fault_is_found(part: str, broken: str, fault: str) -> None:
    assert faults(SOUND) == []
    assert part in SOUND
    assert fault in "; ".join(faults(SOUND.replace(part, broken)))


def test_the_contents_list_every_figure(plane_report: ReportFiles) -> None:
    page = Page(plane_report.page.read_text())
    listed = [each.attributes["href"][1:] for each in page.of("a") if each.inside("nav")]
    assert {each.attributes["id"] for each in page.of("figure")} <= set(listed)


def test_an_animation_is_a_still_picture_until_it_is_played(plane_report: ReportFiles) -> None:
    page = Page(plane_report.page.read_text())
    pictures = [each for each in page.of("img") if each.inside("div", **{"class": "moving"})]
    kinds = [each.attributes["src"].partition(";")[0] for each in pictures]
    assert kinds == ["data:image/gif", "data:image/png"] * 2
    assert [each.inside("details") for each in pictures] == [True, False] * 2


def test_a_drawing_is_enlarged_by_a_tap_on_it(security: str) -> None:
    page = Page(security)
    drawings = [each for each in page.of("img") if each.attributes["class"] == "drawing"]
    assert len(drawings) == 4
    labels = [next(label for label in reversed(each.around) if label.tag == "label") for each in drawings]
    switches = [each for each in page.of("input") if each.inside("span", **{"class": "enlarge"})]
    assert [label in switch.around for label, switch in zip(labels, switches, strict=True)] == [True] * 4


def test_every_run_and_every_seed_can_be_switched_off(security: str) -> None:
    switches = [each for each in Page(security).of("input") if "checked" in each.attributes]
    assert [(each.attributes["name"], each.attributes["value"]) for each in switches] == [
        ("run", "MA-IRL"),
        ("run", "GSIIRL"),
        ("seed", "0"),
        ("seed", "1"),
        ("seed", "2"),
    ]
    assert security.count(f'id="program">{packed("program")}</script>') == 1


@pytest.mark.slow
def test_a_page_with_charts_is_one_small_file_that_names_no_address_to_load(
    plane_runs: dict[str, list[Path]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("altair")
    pytest.importorskip("vl_convert")
    monkeypatch.setattr(charts, "charts_installed", lambda: True)
    files = build_report([path for paths in plane_runs.values() for path in paths], tmp_path / "out")
    page = files.page.read_text()
    assert faults(page) == []
    assert len(page.encode()) < 3_000_000
    assert page.count("<script") == page.count("</script>")
    assert page.count('<script type="module">') == 1
