"""Templates filled with values."""

import base64
import zlib
from typing import Any

import jinja2

from gsiirl.report.words.formulas import formulas
from gsiirl.report.words.markdown import markdown
from gsiirl.report.words.numbers import format_number, unbroken
from gsiirl.runs.measurement_words import bound_in_words, value_in_words


def render(template: str, **values: Any) -> str:
    """The text of a template in `templates/` with `values`; what stands in an `.html` is escaped.

    Raises:
        jinja2.UndefinedError: the template names a value that is not given.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("gsiirl.report"),
        autoescape=jinja2.select_autoescape(["html"]),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["formulas"] = formulas
    environment.filters["packed"] = packed
    environment.filters["unbroken"] = unbroken
    environment.filters["markdown"] = markdown
    environment.globals.update(bound_in_words=bound_in_words, number=format_number, value_in_words=value_in_words)
    return environment.get_template(template).render(**values)


def packed(text: str) -> str:
    """A text for the scripts of a page, at about half its size: `unpack.js` makes it whole again."""
    return base64.b64encode(zlib.compress(text.encode(), level=9)).decode()
