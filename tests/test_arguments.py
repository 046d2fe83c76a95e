"""Arguments of the front door's classes."""

import inspect

import pytest

import gsiirl


@pytest.mark.parametrize("kind", [gsiirl.Problem, gsiirl.GSIIRL])
def test_a_notebook_is_shown_the_arguments_of_a_class_of_two_kinds(kind: type) -> None:
    shown, made = inspect.signature(kind), inspect.signature(kind.__init__)
    assert [*shown.parameters] == [*made.parameters][1:]
    assert len(shown.parameters) > 3
