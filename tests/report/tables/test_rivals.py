"""The learner beside its rivals."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report.made_up import group_of, made_up_run

from gsiirl.report.tables.rivals import rivals_of

ENDS = [-4.6, -4.7, -4.5]
BEST: dict[str, Any] = {"ceiling_return_learner": -4.5, "sharp_return_learner": -4.9}


def test_the_rivals_are_in_their_order(tmp_path: Path) -> None:
    algorithms = ("random-search", "marl", "ma-irl", "paper", "gsiirl")
    rivals = rivals_of(group_of(*(made_up_run(tmp_path / each, each, ENDS, **BEST) for each in algorithms)))
    assert rivals is not None
    assert rivals.subject.label == "GSIIRL"
    assert [row.algorithm for row in rivals.rows] == ["sharp", "marl", "ma-irl", "paper", "random-search", "random"]


def test_returns_differences_verdicts_and_shares_stand_side_by_side(tmp_path: Path) -> None:
    rivals = rivals_of(
        group_of(
            made_up_run(tmp_path / "gsiirl", "gsiirl", ENDS, **BEST),
            made_up_run(tmp_path / "ma-irl", "ma-irl", [-6.7, -6.8, -6.9], first_seed=10),
        )
    )
    assert rivals is not None
    rows = [
        (row.label, row.earned, row.difference, row.verdict.words() if row.verdict else "", row.share_text)
        for row in (rivals.subject, *rivals.rows)
    ]
    minus = "\N{MINUS SIGN}"
    assert rows == [
        ("GSIIRL", f"{minus}4.60 ± 0.10", "\N{EN DASH}", "", "98.0 %"),
        ("sharp MARL", f"{minus}4.90", "+0.30 (0.05 to 0.55)", "better", "92.2 %"),
        ("MARL", f"{minus}6.30", "+1.70 (1.45 to 1.95)", "better", "64.7 %"),
        ("MA-IRL", f"{minus}6.80 ± 0.10", "+2.20 (1.97 to 2.43)", "better", "54.9 %"),
        ("random play", f"{minus}9.60", "+5.00 (4.75 to 5.25)", "better", "0.0 %"),
    ]


def test_marl_of_a_finite_game_is_one_number_whatever_its_seeds(tmp_path: Path) -> None:
    group = group_of(made_up_run(tmp_path / "gsiirl", "gsiirl", ENDS), made_up_run(tmp_path / "marl", "marl", [-6.3]))
    found = rivals_of(group)
    assert found is not None
    marl = found.of("marl")
    assert marl is not None
    assert marl.verdict is not None
    assert (marl.verdict.words(), marl.earned) == ("better", "\N{MINUS SIGN}6.30")


def test_marl_of_trained_policies_is_compared_seed_by_seed_and_deployed(tmp_path: Path) -> None:
    # Returns spread more than they differ, and spread together; MARL's own pair earns far more.
    ours, theirs = np.array([-4.5, -6.4, -8.5]), np.array([-5.0, -7.0, -9.0])
    group = group_of(
        made_up_run(tmp_path / "gsiirl", "gsiirl", list(ours), "crossing", random_return_learner=-30.0),
        made_up_run(tmp_path / "marl", "marl", list(theirs), "crossing", truth_return_learner=0.0),
    )
    found = rivals_of(group)
    assert found is not None
    marl = found.of("marl")
    assert marl is not None
    assert marl.verdict is not None
    assert marl.verdict.words() == "better"
    assert marl.verdict.difference == pytest.approx((ours - theirs).mean())


def test_a_failed_seed_counts_in_verdicts_and_the_mean_over_all_is_there(tmp_path: Path) -> None:
    rivals = rivals_of(group_of(made_up_run(tmp_path / "gsiirl", "gsiirl", [-4.6, -99.0, -4.5], **BEST)))
    assert rivals is not None
    assert rivals.subject.earned == "\N{MINUS SIGN}4.55 ± 0.07"
    assert rivals.subject.over_all_seeds == "all 3 seeds: \N{MINUS SIGN}36.03 ± 54.53"
    assert {row.verdict.words() for row in rivals.rows if row.verdict} == {"cannot tell with 3 seeds"}


def test_the_share_over_all_seeds_stands_beside_that_without_failed_ones(tmp_path: Path) -> None:
    group = group_of(
        made_up_run(tmp_path / "gsiirl", "gsiirl", ENDS, **BEST),
        made_up_run(tmp_path / "ma-irl", "ma-irl", [-7.05, -12.15], **BEST),
    )
    rivals = rivals_of(group)
    assert rivals is not None
    assert rivals.subject.share_over_all_seeds == ""
    watcher = rivals.of("ma-irl")
    assert watcher is not None
    assert (watcher.share_text, watcher.share_over_all_seeds) == ("50.0 %", "all 2 seeds: 0.0 %")
    assert watcher.json()["share_all_seeds"] == pytest.approx(0.0)


def test_who_learns_how_stands_beside_the_names(tmp_path: Path) -> None:
    group = group_of(*(made_up_run(tmp_path / each, each, ENDS) for each in ("gsiirl", "ma-irl", "marl")))
    rivals = rivals_of(group)
    assert rivals is not None
    notes = {row.algorithm: row.note for row in (rivals.subject, *rivals.rows)}
    assert notes["gsiirl"] == "learns by interacting"
    assert notes["ma-irl"] == "learns by watching alone"
    assert notes["marl"] == "given both rewards"


def test_a_run_that_was_interrupted_is_marked_where_it_is_compared(tmp_path: Path) -> None:
    ours, theirs = (made_up_run(tmp_path / each, each, ENDS) for each in ("gsiirl", "ma-irl"))
    (theirs / "summary.json").unlink()
    rivals = rivals_of(group_of(ours, theirs))
    assert rivals is not None
    watcher = rivals.of("ma-irl")
    assert watcher is not None
    assert watcher.note == "learns by watching alone; interrupted: as far as iteration 0"
    assert "interrupted" not in rivals.subject.note
