"""The words of a network's figures."""

from pathlib import Path

import pytest
from report.made_up import group_of
from report.synthetic import RING, SyntheticGame, write_run

from gsiirl.report.security.figures import security_figures


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(("may_wait", "words"), [(False, "must attack something"), (True, "though it might wait")])
def test_why_an_attacker_attacks_in_vain_depends_on_whether_it_may_wait(
    tmp_path: Path, may_wait: bool, words: str
) -> None:
    game = SyntheticGame(RING)
    content = game.content() | {"no_op": {"learner": may_wait, "expert": may_wait}}
    game = type("Game", (SyntheticGame,), {"content": lambda self: content})(RING)
    run = write_run(tmp_path / "run", "gsiirl", game)
    group = group_of(run.path)
    caption = next(each.caption for each in security_figures(group, group.first) if each and each.name.endswith("path"))
    assert words in caption


@pytest.mark.usefixtures("undrawn")
def test_the_end_of_an_encounter_is_explained_where_it_stands(tmp_path: Path) -> None:
    group = group_of(write_run(tmp_path / "run", "gsiirl").path)
    caption = next(each.caption for each in security_figures(group, group.first) if each and each.name.endswith("path"))
    assert caption.endswith("End: what came of the last step's attack is not recorded.")
