"""Formulas of the theory as HTML."""

import pytest

from gsiirl.report.words.formulas import formulas


@pytest.mark.parametrize(
    ("text", "marked"),
    [
        ("f(θ_l, θ_e*)", "f(θ<sub>l</sub>, θ<sub>e</sub>*)"),
        ("∇_{θ_l} f", "∇<sub>θ<sub>l</sub></sub> f"),
        ("μ̂_e − k^(-1/4)", "μ̂<sub>e</sub> − k<sup>-1/4</sup>"),  # noqa: RUF001
        ("(k + 1)^0.101.", "(k + 1)<sup>0.101</sup>."),
        ("dθ_e*/dθ_l", "dθ<sub>e</sub>*/dθ<sub>l</sub>"),
        ("a file_name", "a file_name"),
        ("`well_specified` <", "<code>well_specified</code> &lt;"),
        ("θ_<b>", "θ_&lt;b&gt;"),
    ],
)
def test_indices_are_set_below_or_above_the_line(text: str, marked: str):
    assert formulas(text) == marked
