"""Attack networks from a user's own file: GraphML or JSON (docs/scenarios.md has both formats)."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from gsiirl.errors import InputError, NetworkWarning, warn
from gsiirl.scenarios.file_content import FileContent, network_of
from gsiirl.scenarios.graphml_file import read_graphml
from gsiirl.scenarios.json_file import read_json
from gsiirl.scenarios.network import AttackNetwork, Variant, shown

READERS: Mapping[str, Callable[[bytes], FileContent]] = {
    ".graphml": read_graphml,
    ".xml": read_graphml,
    ".json": read_json,
}
"""Reader of a file's bytes, by the end of the file's name."""

PACKED = {".gz", ".bz2", ".xz", ".zip", ".graphmlz"}
PACKED_BEGINNINGS = (b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"PK\x03\x04")


def read_network(path: str | Path, variant: Variant = "general_sum") -> AttackNetwork:
    """Read a network from a .graphml, .xml (GraphML) or .json file.

    Warns:
        NetworkWarning: of what was read otherwise than it stands in the file, and of what looks like a slip.

    Raises:
        InputError: when the file cannot be read or does not hold a valid network; it names the file and the element.
    """
    path = Path(path)
    content = read_content(path)
    with named(path):
        return network_of(content, path.stem, variant, partial(_say, path))


def read_content(path: Path) -> FileContent:
    """What a .graphml, .xml (GraphML) or .json file lists, whether or not it is enough for a game.

    Raises:
        InputError: when the file cannot be read; it names the file and the element.
    """
    kind = path.suffix.lower()
    if kind not in READERS and kind not in PACKED:
        raise InputError(
            str(path), f"is of unknown kind '{shown(kind)}'", f"give a file ending in {', '.join(READERS)}"
        )
    try:
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(str(path), f"cannot be read ({reason})", "give a readable file") from None
    if kind in PACKED or content.startswith(PACKED_BEGINNINGS):
        raise InputError(str(path), "is packed", "unpack it (gunzip, unzip) and give the file inside")

    with named(path):
        return READERS[kind](content)


@contextmanager
def named(path: Path) -> Iterator[None]:
    """What is refused inside is said to be of this file."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error.field}", error.problem, error.mend) from None


def _say(path: Path, note: str) -> None:
    warn(f"{path}: {note}", NetworkWarning)
