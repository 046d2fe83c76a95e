"""The error for a file that does not hold what it should."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gsiirl.errors import InputError

START_AGAIN = "start the run again in another folder"
"""What to do about a damaged file of a run."""


@contextmanager
def refuse_damaged(path: Path, mend: str = START_AGAIN) -> Iterator[None]:
    """Turn an error about a missing or wrong value of `path` into one that names the file.

    Raises:
        InputError: a value is missing or wrong, and `mend` says what to do about it; or as raised inside.
    """
    try:
        yield
    except InputError:
        raise
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        raise InputError(str(path), f"is damaged ({error!r})", mend) from error
