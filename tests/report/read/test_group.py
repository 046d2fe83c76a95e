"""What is said of a game as a whole."""

from pathlib import Path

import pytest
from report.made_up import group_of, made_up_run

from gsiirl.report.read.group import group_runs
from gsiirl.report.read.run import ReportedRun


@pytest.mark.parametrize(
    ("experiment", "variant", "sentence"),
    [
        (
            "security",
            "general_sum",
            "The defender of a network meets its attacker, without being told what the attacker wants.",
        ),
        ("security", "zero_sum", "The defender of a network meets its attacker."),
        ("crossing", "", "A robot meets a human whose way it crosses, without being told what the human wants."),
        (
            "deception",
            "separate_target",
            "Two agents that hide their target meet an adversary that looks for it, without being told what the "
            "adversary wants.",
        ),
        ("pursuit", "", "A learner meets an expert, without being told what the expert wants."),
    ],
)
def test_a_stranger_is_told_who_meets_whom(tmp_path: Path, experiment: str, variant: str, sentence: str) -> None:
    assert group_of(made_up_run(tmp_path / "run", "gsiirl", [-4.6], experiment, variant=variant)).meeting == sentence


def test_general_sum_does_not_say_that_losses_and_gains_differ(tmp_path: Path) -> None:
    # They may be the same, as in a network that is built from a plain topology.
    group = group_of(made_up_run(tmp_path / "run", "gsiirl", [-4.6], variant="general_sum"))
    assert group.variant == "General-sum: what the defender loses need not be what the attacker gains"


def test_games_of_one_name_are_told_apart_by_variant_then_by_number(tmp_path: Path) -> None:
    games = [("g", "zero_sum", 10), ("other", "zero_sum", 10), ("g", "general_sum", 10), ("g", "general_sum", 20)]
    paths = [
        made_up_run(
            tmp_path / str(number), "gsiirl", [-4.6], game={"name": name, "variant": variant, "horizon": horizon}
        )
        for number, (name, variant, horizon) in enumerate(games)
    ]
    assert [group.title for group in group_runs([ReportedRun.read(path) for path in paths])] == [
        "Security: g, zero sum",
        "Security: other",
        "Security: g, general sum, 1 of 2",
        "Security: g, general sum, 2 of 2",
    ]


def test_games_of_one_name_without_a_variant_are_numbered(tmp_path: Path) -> None:
    paths = [made_up_run(tmp_path / str(horizon), "gsiirl", [-4.6], game={"horizon": horizon}) for horizon in (10, 20)]
    groups = group_runs([ReportedRun.read(path) for path in paths])
    assert [group.title for group in groups] == ["Security: g, 1 of 2", "Security: g, 2 of 2"]
