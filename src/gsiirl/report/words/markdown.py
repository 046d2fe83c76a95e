"""A user's words in Markdown."""


def markdown(text: str) -> str:
    """`text` as it stands, in one line of a table."""
    for mark, literal in (("\\", "\\\\"), ("&", "&amp;"), ("<", "&lt;"), ("|", "\\|"), ("`", "\\`"), ("*", "\\*")):
        text = text.replace(mark, literal)
    return " ".join(text.split())
