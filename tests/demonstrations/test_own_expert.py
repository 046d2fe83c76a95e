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


def test_what_is_shown_is_checked_and_doubted_once() -> None:
    asked = []
    own = OwnExpert(
        Shows(),
        lambda seen, number: ("checked", *seen, number),
        lambda seen, policy: asked.append((seen, policy)) or ("odd" if policy == "b" else ""),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert own.demonstrate("a", 3, KEY) == ("checked", "a", 3, 3)
    with pytest.warns(FitWarning, match="odd"):
        own.demonstrate("b", 3, KEY)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        own.demonstrate("b", 3, KEY)
    assert asked[1] == (("checked", "b", 3, 3), "b")


def test_who_cannot_demonstrate_is_refused() -> None:
    with pytest.raises(InputError) as refused:
        OwnExpert(object(), lambda seen, number: seen, lambda seen, policy: "")
    assert refused.value.field == "expert"
