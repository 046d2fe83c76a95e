"""Somebody's own expert, whose demonstrations are checked."""

import warnings
from collections.abc import Callable
from typing import Any

from jaxtyping import PRNGKeyArray

from gsiirl.errors import FitWarning, InputError


class OwnExpert:
    """Somebody's own expert.

    `checked(seen, number)` gives its demonstrations the library's types; `doubts(seen, learner_policy)` says in a line
    what is odd about them, or nothing, and is a warning the first time.

    Raises:
        InputError: it cannot demonstrate.
    """

    def __init__(self, expert: Any, checked: Callable[[Any, int], Any], doubts: Callable[[Any, Any], str]) -> None:
        if not callable(getattr(expert, "demonstrate", None)):
            raise InputError(
                "expert", f"{type(expert).__name__} has no demonstrate", "give it demonstrate(policy, number, key)"
            )
        self._expert, self._checked, self._doubts = expert, checked, doubts
        self._warned = False

    def demonstrate(self, learner_policy: Any, number: int, key: PRNGKeyArray) -> Any:
        """`number` episodes against `learner_policy`."""
        seen = self._checked(self._expert.demonstrate(learner_policy, number, key), number)
        if doubt := self._doubts(seen, learner_policy):
            if not self._warned:
                warnings.warn(doubt, FitWarning, stacklevel=2)
            self._warned = True
        return seen
