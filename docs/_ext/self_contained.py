"""A page must be readable without a network: nothing that it loads may lie elsewhere. Links may."""

import re
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.errors import SphinxError

LOADS = re.compile(r"""<(?!a\b)\w+[^>]*\s(?:src|href|data)\s*=\s*["']?(?:https?:)?//[^>]*>""", re.IGNORECASE)
STYLE_LOADS = re.compile(r"""(?:url\(|@import)\s*["']?(?:https?:)?//[^;)]*""", re.IGNORECASE)


def remote_loads(site: Path) -> list[str]:
    """What the pages and style sheets of a built site load from elsewhere."""
    found = []
    for pattern, looked_for in (("*.html", LOADS), ("*.css", STYLE_LOADS)):
        for file in sorted(site.rglob(pattern)):
            found += [f"{file.relative_to(site)}: {each}" for each in looked_for.findall(file.read_text())]
    return found


def refuse(app: Sphinx, failure: Exception | None) -> None:
    """Fail the build of a site that loads anything from elsewhere."""
    if failure is None and app.builder.name == "html" and (found := remote_loads(Path(app.outdir))):
        raise SphinxError("loaded from the network:\n" + "\n".join(found))


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("build-finished", refuse)
    return {"parallel_read_safe": True}
