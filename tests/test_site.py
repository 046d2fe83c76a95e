"""What the site's extensions of Sphinx do."""

import json
from pathlib import Path

import pytest
from docstrings import restructured
from self_contained import remote_loads


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a `name` of it", "a ``name`` of it"),
        ("`gradient`(θ)", "``gradient``\\ (θ)"),
        ("of |S| states, π* and `a*b`", "of \\|S\\| states, π\\* and ``a*b``"),
        ("r_e and x_", "r_e and x\\_"),
        ("``twice`` is once", "``twice`` is once"),
    ],
)
def test_plain_docstrings_mean_the_same_in_restructured_text(text: str, said: str) -> None:
    assert restructured(text) == said


def test_what_a_page_loads_from_elsewhere_is_found_and_links_are_not(tmp_path: Path) -> None:
    (tmp_path / "page.html").write_text(
        '<a href="https://elsewhere.org">a link</a> <img src="figures/here.png"> <script src="//elsewhere.org/a.js">'
    )
    (tmp_path / "site.css").write_text("@font-face { src: url(https://elsewhere.org/font) } a { color: red }")
    found = remote_loads(tmp_path)
    assert found == ['page.html: <script src="//elsewhere.org/a.js">', "site.css: url(https://elsewhere.org/font"]


def test_notebooks_are_kept_without_outputs() -> None:
    notebooks = sorted((Path(__file__).parents[1] / "docs" / "notebooks").glob("*.ipynb"))
    assert len(notebooks) == 2
    for notebook in notebooks:
        cells = json.loads(notebook.read_text())["cells"]
        assert not any(cell.get("outputs") or cell.get("execution_count") for cell in cells), notebook
