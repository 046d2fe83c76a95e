"""What all charts have in common: Vega-Lite's JSON, and the mark that the pointer is nearest to."""

import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import altair

ROW = "(datum.datum || datum)"
"""The row of a mark in an expression of Vega; that of the nearest mark is `datum.datum`."""


def specification(layers: "list[altair.Chart]", **parameters: list) -> str:
    """Layers as one chart in Vega-Lite's JSON, as wide as its place, with lists that a page can change."""
    import altair as alt

    chart = (
        alt.layer(*layers)
        .add_params(*(alt.param(name, value=value) for name, value in parameters.items()))
        .properties(width="container", height=210, background="transparent", autosize=alt.AutoSizeParams(type="fit-x"))
        .configure(aria=False, font="system-ui, sans-serif")
        .configure_axis(labelFontSize=12, titleFontSize=12, titleFontWeight="normal", gridColor="#e2e8f0")
        .configure_view(stroke=None)
    )
    return json.dumps(chart.to_dict())


def nearest_mark(chart: "altair.Chart", told: str, *encodings: object) -> "altair.Chart":
    """A point at the mark that the pointer is nearest to, which tells `told`, an expression of Vega."""
    import altair as alt

    nearest = alt.selection_point(name="nearest", nearest=True, on="pointerover", clear="pointerout", empty=False)
    opacity = alt.condition(nearest, alt.value(1), alt.value(0))
    marks = chart.mark_point(filled=True, size=70, clip=True)
    return marks.encode(*encodings, opacity=opacity, tooltip=alt.value(alt.ExprRef(told))).add_params(nearest)
