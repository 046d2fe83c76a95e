"""The type checker that the tests put on every function of the package (see pyproject.toml)."""

from collections.abc import Callable
from typing import Any, Self

from beartype import BeartypeConf, beartype

# An int passes for a float, as it does for the static checker.
_CONFIGURATION = BeartypeConf(is_pep484_tower=True)


def check(function: Callable[..., Any]) -> Callable[..., Any]:
    """`function`, with arguments and result checked at run time."""
    # What `Self` stands for is not known here, where methods are decorated one by one.
    function.__annotations__ = {name: hint for name, hint in function.__annotations__.items() if hint is not Self}
    return beartype(conf=_CONFIGURATION)(function)
