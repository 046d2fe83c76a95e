"""Filling in the templates."""

from typing import Any

import jinja2

from gsiirl.report.comparison_table import RETURNS_NOTE
from gsiirl.report.estimate import format_number
from gsiirl.report.formulas import formulas
from gsiirl.report.quality_table import METRICS, used_metrics
from gsiirl.runs.measurement_words import bound_in_words, value_in_words


def render(template: str, **values: Any) -> str:
    """A template of `templates/`, with the functions that templates use."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("gsiirl.report"),
        autoescape=jinja2.select_autoescape(["html"]),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["formulas"] = formulas
    environment.globals.update(
        bound_in_words=bound_in_words,
        metrics=METRICS,
        number=format_number,
        returns_note=RETURNS_NOTE,
        used_metrics=used_metrics,
        value_in_words=value_in_words,
    )
    return environment.get_template(template).render(**values)
