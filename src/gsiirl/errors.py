"""The one error a user meets for bad input, and the warnings."""

import sys
import traceback
import warnings

INSIDE = {"gsiirl", "equinox", "jax", "jaxtyping", "beartype"}
"""Where a call is still inside the library."""
LONGEST = 400
"""Characters of each of the three parts of an error that are shown."""


def printable(text: str) -> str:
    """`text` with a blank for every character that a terminal would act on, or cannot show."""
    return "".join(each if each.isprintable() else " " for each in text)


class InputError(ValueError):
    """Bad input, said in one line: the field, what is wrong with it, and how to mend it.

    Attributes:
        field: the name the user knows it by (a flag, a configuration key, a file, an argument).
        problem: what is wrong, with the offending value.
        mend: what to do instead.
    """

    def __init__(self, field: str, problem: str, mend: str) -> None:
        self.field = field
        self.problem = problem
        self.mend = mend
        # What a file holds may be of any length, a line may not.
        field, problem, mend = (
            part if len(part) <= LONGEST else f"{part[:LONGEST]}..." for part in (field, problem, mend)
        )
        # Nor may it hold characters that a terminal acts on.
        super().__init__(" ".join(printable(f"{field}: {problem}; {mend}").split()))

    def __reduce__(self) -> tuple[type["InputError"], tuple[str, str, str]]:
        return type(self), (self.field, self.problem, self.mend)


class InputWarning(UserWarning):
    """Something that was read may be other than it looks; the message says what in one line."""


class FitWarning(UserWarning):
    """What was learned may be worse than it looks; the message says what is wrong and what helps."""


class NetworkWarning(InputWarning):
    """A network was read otherwise than its file may seem to say; the message says what was made of it."""


def warn(message: str, category: type[Warning]) -> None:
    """Warn, and name the line of the user's program that called the library.

    Python shows a warning once for every line: a warning at a line of the library would hide all later ones.
    """
    levels = enumerate(traceback.walk_stack(sys._getframe()), start=1)
    modules = ((level, frame.f_globals.get("__name__", "").partition(".")[0]) for level, (frame, _) in levels)
    warnings.warn(message, category, stacklevel=next((level for level, name in modules if name not in INSIDE), 1))
