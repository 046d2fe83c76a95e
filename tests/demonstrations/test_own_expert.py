"""Somebody's own expert: what it shows is checked, and what is odd about it is said once."""

import warnings
from typing import Any

import jax
import pytest

from gsiirl import FitWarning, InputError
from gsiirl.demonstrations.own_expert import OwnExpert

KEY = jax.random.key(0)


class Shows:
    """Shows the policy and the number of episodes that it was asked for."""

    def demonstrate(self, learner_policy: Any, number: int, key: Any) -> Any:
        return learner_policy, number


def test_what_is_shown_is_checked_and_each_kind_of_doubt_said_once() -> None:
    asked = []
    own = OwnExpert(
        Shows(),
        lambda seen, number: ("checked", *seen, number),
        lambda seen, policy: asked.append((seen, policy)) or {kind: f"{kind} is odd" for kind in policy},
    )
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        for policy in ("", "a", "ab", "ab"):
            assert own.demonstrate(policy, 3, KEY) == ("checked", policy, 3, 3)
    assert [str(each.message) for each in said] == ["a is odd", "b is odd"]
    assert {each.category for each in said} == {FitWarning}
    assert asked[1] == (("checked", "a", 3, 3), "a")


def test_who_cannot_demonstrate_is_refused() -> None:
    with pytest.raises(InputError) as refused:
        OwnExpert(object(), lambda seen, number: seen, lambda seen, policy: {})
    assert refused.value.field == "expert"
