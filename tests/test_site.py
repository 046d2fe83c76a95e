"""What the site's extensions of Sphinx do."""

import json
from pathlib import Path

import pytest
from docstrings import plain, restructured, rewrite, tidy
from docutils.nodes import paragraph
from docutils.utils import new_document
from jaxtyping import PRNGKeyArray
from numpy.typing import ArrayLike
from self_contained import remote_loads
from sphinx.addnodes import desc, desc_content, desc_signature
from sphinx.ext.napoleon import Config
from sphinx.ext.napoleon.docstring import GoogleDocstring
from sphinx.util.typing import stringify_annotation


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


@pytest.mark.parametrize(
    ("signature", "said"),
    [
        (f"(rows: {stringify_annotation(ArrayLike | None, 'smart')} = None)", "(rows: ArrayLike | None = None)"),
        (f"(key: {stringify_annotation(PRNGKeyArray, 'smart')})", "(key: PRNGKeyArray)"),
        ("(x: list[~typing.Annotated[float, ~pydantic.BeforeValidator(func=~a._b, c=d)]])", "(x: list[float])"),
        ("(names: dict[str, str] = <factory>)", "(names: dict[str, str] = ...)"),
        ("Bool[jaxlib._jax.Array, 'S'] | None", "Bool[Array, 'S'] | None"),
    ],
)
def test_signatures_have_types_by_their_names(signature: str, said: str) -> None:
    assert plain(signature) == said


def test_types_of_fields_are_short_and_lines_on_aliases_are_left_out_of_descriptions_alone() -> None:
    signature = desc_signature("", "held: Int[jaxlib._jax.Array, '']")
    content = desc_content("", paragraph("", "What is held."), paragraph("", "alias of Sides[']]"))
    page = new_document("page")
    page += [desc("", signature, content), paragraph("", "alias of nothing, in prose")]
    tidy(None, page)  # pyright: ignore[reportArgumentType]
    assert signature.astext() == "held: Int[Array, '']"
    assert content.astext() == "What is held."
    assert page.astext().endswith("alias of nothing, in prose")


@pytest.mark.parametrize("what", ["attribute", "data", "property"])
def test_what_stands_before_a_colon_is_not_taken_for_a_type(what: str) -> None:
    lines = ["In words, what is open: single weights.", "", "Raises:", "    ValueError: nothing is known."]
    rewrite(None, what, "Reward.open", None, None, lines)  # pyright: ignore[reportArgumentType]
    shown = str(GoogleDocstring(lines, Config(), None, what, "Reward.open"))  # pyright: ignore[reportArgumentType]
    assert "In words, what is open: single weights." in shown
    assert ":type:" not in shown
    assert ":raises ValueError: nothing is known." in shown


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
