"""The program of the charts is small, and loads nothing."""

import re

import pytest

from gsiirl.report.output.chart_program import chart_program, charts_installed, vega_lite_version
from gsiirl.report.output.rendering import packed


def test_without_either_package_there_are_no_charts(monkeypatch: pytest.MonkeyPatch) -> None:
    for lacking in ("altair", "vl_convert"):
        monkeypatch.setattr(
            "gsiirl.report.output.chart_program.find_spec",
            lambda name, lacking=lacking: None if name == lacking else name,
        )
        assert not charts_installed()


@pytest.mark.slow
def test_the_program_loads_nothing_and_shows_the_charts_that_altair_writes() -> None:
    vl_convert = pytest.importorskip("vl_convert")
    assert vega_lite_version() in vl_convert.get_vegalite_versions()
    program = chart_program()
    assert ".charts" in program
    # Names of formats, and the page that an error of a programmer is told to read.
    hosts = set(re.findall(r"https?://([^/\"'`]*)", program))
    assert hosts <= {"www.w3.org", "vega.github.io", "github.com"}
    assert len(packed(program)) < 500_000
