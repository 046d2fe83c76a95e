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
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise InputError(str(path), f"is damaged ({error!r})", mend) from error


@contextmanager
def refuse_unreadable(field: str, path: Path, mend: str) -> Iterator[None]:
    """Turn a failure to look at `path` into an error that says so.

    Raises:
        InputError: the user may not look there, the name is too long, or the like.
    """
    try:
        yield
    except OSError as error:
        what = "" if field == str(path) else f"{path} "
        raise InputError(field, f"{what}cannot be read ({error.strerror or error})", mend) from error
