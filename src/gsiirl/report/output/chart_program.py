"""The program that shows charts on a page; it comes with the extra `interactive`."""

from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec

from gsiirl.report.figures.page_figure import PageFigure
from gsiirl.report.output.rendering import render


def charts_installed() -> bool:
    """Whether the extra is installed: Altair writes the charts, vl-convert holds the program that shows them."""
    return all(find_spec(name) is not None for name in ("altair", "vl_convert"))


def chart_program_for(figures: Iterable[PageFigure]) -> str:
    """The program for a page of these figures: empty where none of them has charts."""
    return chart_program() if any(figure.charts for figure in figures) else ""


@cache
def chart_program() -> str:
    """Vega, Vega-Lite, vega-embed and the page's own few lines as one piece of JavaScript, which loads nothing."""
    import vl_convert

    return vl_convert.javascript_bundle(snippet=render("page.js"), vl_version=vega_lite_version())


def vega_lite_version() -> str:
    """The version that Altair writes, as vl-convert names it: 6.4."""
    import altair

    return altair.SCHEMA_VERSION.removeprefix("v").rpartition(".")[0]
