"""Docstrings of the package are plain text with `code` in backticks; this makes reStructuredText of them."""

import inspect
import re
from typing import Any

from docutils import nodes
from jaxtyping import PRNGKeyArray
from numpy.typing import ArrayLike
from sphinx.addnodes import desc_content, desc_signature
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation

import gsiirl

# Unions that Sphinx writes out in full, and what the code calls them.
NAMES = {
    stringify_annotation(ArrayLike, "smart"): "ArrayLike",
    stringify_annotation(PRNGKeyArray, "smart"): "PRNGKeyArray",
}
ANNOTATED = re.compile(r"(?:~?typing\.)?Annotated\[(\w+), [^()]*\([^()]*\)\]")
# What Sphinx leaves of a field's Annotated[str, StringConstraints(...)].
CONSTRAINED = re.compile(r"^StringConstraints\([^()]*\)\]$")
CODE = re.compile(r"``.*?``|`[^`]*`")
SPECIAL = re.compile(r"[*|\\]|(?<=\w)_(?=\W|$)")


def restructured(text: str) -> str:
    """The same text: `code` is a literal, and stars, bars and trailing underscores stand for themselves."""
    pieces, end = [], 0
    for code in CODE.finditer(text):
        pieces += [SPECIAL.sub(r"\\\g<0>", text[end : code.start()])]
        # An escaped space, which is not shown, parts a literal from what touches it.
        before = "" if text[: code.start()][-1:].isspace() or not code.start() else "\\ "
        after = "" if text[code.end() : code.end() + 1].isspace() or code.end() == len(text) else "\\ "
        pieces += [f"{before}``{code[0].strip('`')}``{after}"]
        end = code.end()
    return "".join([*pieces, SPECIAL.sub(r"\\\g<0>", text[end:])])


def rewrite(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Rewrite a docstring in place, before napoleon reads it."""
    lines[:] = restructured("\n".join(lines)).split("\n")
    if what in ("attribute", "data", "property"):
        # In the first line napoleon takes what stands before a colon for a type. An empty comment is shown nowhere.
        lines[:0] = ["..", ""]


def plain(signature: str) -> str:
    """The same signature, with types by the names that they are known by."""
    for union, name in NAMES.items():
        signature = signature.replace(union, name)
    signature = CONSTRAINED.sub("str", ANNOTATED.sub(r"\1", signature))
    return signature.replace("<factory>", "...").replace("jaxlib._jax.Array", "Array")


def shorter(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Rewrite a signature before it is read."""
    return (signature and plain(signature), returns and plain(returns))


def tidy(app: Sphinx, page: nodes.document) -> None:
    """Shorten types of fields, which no earlier event hands over; drop the lines "alias of", which Sphinx garbles."""
    for signature in page.findall(desc_signature):
        for text in list(signature.findall(nodes.Text)):
            text.parent.replace(text, nodes.Text(plain(text)))
    for content in page.findall(desc_content):
        content[:] = [part for part in content if not part.astext().startswith("alias of ")]


def finite_signatures(app: Sphinx) -> None:
    """Of the classes that serve finite and continuous games, show the arguments that finite games have."""
    for each in (gsiirl.Problem, gsiirl.GSIIRL):
        _, *others = inspect.signature(each.__init__).parameters.values()
        each.__signature__ = inspect.Signature(others)  # pyright: ignore[reportAttributeAccessIssue]


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("builder-inited", finite_signatures)
    app.connect("autodoc-process-docstring", rewrite, priority=100)
    app.connect("autodoc-process-signature", shorter)
    app.connect("doctree-read", tidy)
    return {"parallel_read_safe": True}
