"""Formulas of the theory as HTML."""

import re

from markupsafe import Markup, escape

SCRIPT = re.compile(
    r"((?:[\u0391-\u03c9]|(?<![^\W\d_])[^\W\d_])[\u0300-\u036f]*|[∇)])([_^])(\{(?:[^{}]|\{[^{}]*\})*\}|\([^()]*\)|[0-9]+\.[0-9]+|[^\W_]+)"
)
"""A symbol with its accents, _ or ^, and an index."""

CODE = re.compile("`([^`]+)`")


def formulas(text: str) -> Markup:
    """`text` as HTML: what follows _ or ^ on a one-letter symbol is set below or above the line, and `this` as code."""
    return Markup(CODE.sub(r"<code>\1</code>", _raised(str(escape(text)))))


def _raised(text: str) -> str:
    def mark(found: re.Match[str]) -> str:
        symbol, sign, index = found.groups()
        tag = "sub" if sign == "_" else "sup"
        return f"{symbol}<{tag}>{_raised(index[1:-1] if index[0] in '{(' else index)}</{tag}>"

    return SCRIPT.sub(mark, text)
