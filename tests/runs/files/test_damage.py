"""A damaged file is named, with what to do about it."""

from pathlib import Path
from typing import Any

import pytest

from gsiirl.errors import InputError
from gsiirl.runs.files.damage import refuse_damaged


@pytest.mark.parametrize("content", [{}, {"seed": "many"}, {"seed": None}])
def test_a_missing_or_wrong_value_names_the_file(content: dict[str, Any]) -> None:
    told = r"run/game.json: is damaged \(.*Error\(.*\)\); start the run again in another folder"
    with pytest.raises(InputError, match=told), refuse_damaged(Path("run/game.json")):
        int(content["seed"])


def test_what_is_refused_inside_keeps_its_words() -> None:
    with (
        pytest.raises(InputError, match=r"^learned.json: is damaged: no JSON object; mend it$"),
        refuse_damaged(Path("summary.json")),
    ):
        raise InputError("learned.json", "is damaged: no JSON object", "mend it")
