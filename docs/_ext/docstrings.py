"""Docstrings of the package are plain text with `code` in backticks; this makes reStructuredText of them."""

import inspect
import re
from typing import Any

from sphinx.application import Sphinx

import gsiirl

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


def shorter(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Arrays in a signature by the name that they are known by."""
    one, other = (text and text.replace("jaxlib._jax.Array", "Array") for text in (signature, returns))
    return one, other


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
    return {"parallel_read_safe": True}
