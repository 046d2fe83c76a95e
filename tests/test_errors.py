"""Where a warning of the library stands."""

import warnings
from typing import Any

import jax

from gsiirl.demonstrations.own_expert import OwnExpert
from gsiirl.errors import FitWarning, warn

KEY = jax.random.key(0)


def test_a_warning_is_of_the_line_that_called_the_library() -> None:
    class Expert:
        def demonstrate(self, learner_policy: str, number: int, key: Any) -> int:
            return number

    def odd() -> OwnExpert:
        return OwnExpert(Expert(), lambda seen, number: seen, lambda seen, policy: {"odd": "is odd"})

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("default")
        for _ in range(2):
            warn("is odd", FitWarning)
        for _ in range(2):
            odd().demonstrate("policy", 1, KEY)
        odd().demonstrate("policy", 1, KEY)
    assert [each.category for each in said] == [FitWarning] * 3
    assert {each.filename for each in said} == {__file__}
    assert len({each.lineno for each in said}) == 3
