"""The plan of an ablation, as `ablation.json` holds it: which run folders below it are which variant."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

from gsiirl.runs.files.atomic import refuse_unwritable
from gsiirl.runs.files.checksum import carries_checksum
from gsiirl.runs.files.json_file import as_typed, read_versioned_json, versioned, write_json

PLAN = "ablation.json"


@dataclass(frozen=True)
class AblationVariant:
    """One set of settings; `description` says what it changes over the one before."""

    name: str
    description: str


@dataclass(frozen=True)
class Ablation:
    """Variants in the order of the changes; the run of variant v on graph g is in the folder g/v."""

    graphs: list[str]
    variants: list[AblationVariant]

    def write(self, folder: Path) -> None:
        """Write `ablation.json` into `folder`.

        Raises:
            InputError: the folder cannot be written.
        """
        with refuse_unwritable("--out", folder):
            write_json(folder / PLAN, versioned(asdict(self)))

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Read `ablation.json` from `folder`.

        Raises:
            InputError: missing, damaged, or of another format.
        """
        path, mend = folder / PLAN, "run gsiirl ablation again"
        content = read_versioned_json(path, mend)
        ablation = as_typed(cls, content, path, mend)
        carries_checksum(content, folder)
        return ablation
