"""Somebody's own expert, whose demonstrations are checked."""

from collections.abc import Callable
from typing import Any

from jaxtyping import PRNGKeyArray

from gsiirl.errors import FitWarning, InputError, warn


class OwnExpert:
    """Somebody's own expert.

    `checked(seen, number)` gives its demonstrations the library's types. `doubts(seen, learner_policy)` says what is
    odd about them, a line for each kind of oddity; the first line of a kind is a warning.

    Raises:
        InputError: it cannot demonstrate.
    """

    def __init__(
        self, expert: Any, checked: Callable[[Any, int], Any], doubts: Callable[[Any, Any], dict[str, str]]
    ) -> None:
        if not callable(getattr(expert, "demonstrate", None)):
            raise InputError(
                "expert", f"{type(expert).__name__} has no demonstrate", "give it demonstrate(policy, number, key)"
            )
        self._expert, self._checked, self._doubts = expert, checked, doubts
        self._warned = set[str]()

    def demonstrate(self, learner_policy: Any, number: int, key: PRNGKeyArray) -> Any:
        """`number` episodes against `learner_policy`."""
        seen = self._checked(self._expert.demonstrate(learner_policy, number, key), number)
        for kind, doubt in self._doubts(seen, learner_policy).items():
            if kind not in self._warned:
                warn(doubt, FitWarning)
            self._warned.add(kind)
        return seen
