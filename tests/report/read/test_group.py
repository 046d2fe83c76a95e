"""What is said of a game as a whole."""

from pathlib import Path

import pytest
from report.made_up import group_of, made_up_run


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
    assert group.variant == "general-sum: what the defender loses need not be what the attacker gains"
