"""The three sentences of a game follow from the numbers."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report.made_up import group_of, made_up_run

from gsiirl.report.page.takeaways import gain_note, takeaways
from gsiirl.report.read.group import GameGroup
from gsiirl.report.tables.rivals import rivals_of

ENDS = [-4.6, -4.7, -4.5]
BEST: dict[str, Any] = {"ceiling_return_learner": -4.5, "sharp_return_learner": -4.9}


def said(group: GameGroup) -> list[str]:
    return takeaways(group, rivals_of(group))


def alone(folder: Path, deployed: list[float], experiment: str = "security", **metrics: Any) -> list[str]:
    return said(group_of(made_up_run(folder / "gsiirl", "gsiirl", deployed, experiment, **metrics)))


def test_the_share_of_what_could_be_gained_comes_first(tmp_path: Path) -> None:
    assert alone(tmp_path, ENDS, **BEST)[0] == (
        "GSIIRL's defender reached 98.0 % of what could be gained: it earns \N{MINUS SIGN}4.60 ± 0.10 an encounter, "
        "random play (0 %) \N{MINUS SIGN}9.60, the best way found with both rewards known (100 %) \N{MINUS SIGN}4.50."
    )


def test_where_random_play_is_the_best_there_is_nothing_to_gain(tmp_path: Path) -> None:
    ten: dict[str, Any] = dict.fromkeys(
        ("truth_return_learner", "sharp_return_learner", "ceiling_return_learner"), -10.0
    )
    reached, compared = alone(tmp_path, [-10.0, -10.0 + 2e-15], random_return_learner=-10.0 - 2e-15, **ten)
    assert reached.startswith("Nothing can be gained here: random play and the best way found")
    assert reached.endswith("earn the same, \N{MINUS SIGN}10.00. GSIIRL's defender earns \N{MINUS SIGN}10.00 ± 0.00.")
    assert compared == "GSIIRL does the same as sharp MARL, MARL and random play."


def test_rivals_are_named_by_verdict_in_their_order(tmp_path: Path) -> None:
    group = group_of(
        made_up_run(tmp_path / "gsiirl", "gsiirl", ENDS, **BEST),
        made_up_run(tmp_path / "paper", "paper", [-4.0, -6.0, -4.2]),
        made_up_run(tmp_path / "ma-irl", "ma-irl", [-4.1, -4.2, -4.0]),
        made_up_run(tmp_path / "marl", "marl", [-6.3] * 3),
    )
    assert said(group)[1] == (
        "GSIIRL does better than sharp MARL, MARL and random play and worse than MA-IRL; against the paper's preset "
        "one cannot tell with 3 seeds."
    )


def test_one_seed_declares_nothing(tmp_path: Path) -> None:
    assert alone(tmp_path, [-4.6])[1] == "Against MARL and random play one cannot tell with 1 seed."


def test_in_a_game_of_trained_policies_the_gain_is_that_of_marl_deployed(tmp_path: Path) -> None:
    # As trained, MARL's pair earns 9; once the real adversary has answered, its learner earns 7.5.
    gsiirl = made_up_run(tmp_path / "gsiirl", "gsiirl", [7.9, 8.0, 8.1], "deception", truth_return_learner=9.0)
    marl = made_up_run(tmp_path / "marl", "marl", [7.4, 7.5, 7.6], "deception", truth_return_learner=9.0)
    group = group_of(gsiirl, marl)
    reached, compared = said(group)
    assert reached == (
        "GSIIRL's good agents reached 102.9 % of what MARL gains, which is given both rewards: they earn 8.00 ± "
        "0.10 an encounter, random play (0 %) \N{MINUS SIGN}9.60, MARL's good agents, deployed too (100 %) 7.50."
    )
    assert compared == "GSIIRL does better than MARL and random play."
    assert "no best is known in a game of this kind" in gain_note(group, rivals_of(group))


def test_a_pair_as_it_was_trained_is_compared_with_nothing(tmp_path: Path) -> None:
    reached, compared = alone(tmp_path, [7.9, 8.0, 8.1], "deception", truth_return_learner=9.0)
    assert reached.endswith("deployed, earn 8.00 ± 0.10 an encounter. Random play earns \N{MINUS SIGN}9.60.")
    assert compared == "GSIIRL does better than random play."


def test_failed_seeds_are_counted_and_the_mean_over_all_stands_beside(tmp_path: Path) -> None:
    reached, compared = alone(tmp_path, [-4.6, -99.0, -4.5], **BEST)
    assert reached.startswith("In 2 of 3 seeds (1 failed) GSIIRL's defender reached 99.0 % of what could be gained")
    assert reached.endswith("Over all 3 seeds it earns \N{MINUS SIGN}36.03 ± 54.53 (\N{MINUS SIGN}518.3 %).")
    assert compared == "Against sharp MARL, MARL and random play one cannot tell with 3 seeds."


@pytest.mark.parametrize(
    ("second", "overall"),
    [(-99.0, "it earns \N{MINUS SIGN}98.50 ± 0.71"), (np.nan, "there is no mean, since a seed has no number")],
)
def test_a_learner_all_whose_seeds_failed_is_still_the_one_spoken_of(
    tmp_path: Path, second: float, overall: str
) -> None:
    group = group_of(
        made_up_run(tmp_path / "gsiirl", "gsiirl", [-98.0, second]), made_up_run(tmp_path / "ma-irl", "ma-irl", ENDS)
    )
    assert said(group)[0] == (
        f"All 2 seeds of GSIIRL's defender failed: over all 2 seeds {overall}. Random play earns \N{MINUS SIGN}9.60."
    )


def test_the_correlation_and_its_price_are_told(tmp_path: Path) -> None:
    found = alone(tmp_path, ENDS, expert_reward_pearson=0.9971, expert_trajectories=5000.0)
    assert found[2] == (
        "What the attacker wants, GSIIRL learned to a correlation of 0.997 with the truth (1 is perfect), from 5,000 "
        "observed encounters a seed."
    )


def test_a_correlation_that_is_not_defined_is_no_number(tmp_path: Path) -> None:
    found = alone(tmp_path, ENDS, expert_reward_pearson=0.0)
    assert found[2].endswith("so that a correlation is not defined.")


def test_regret_stands_beside_the_share(tmp_path: Path) -> None:
    group = group_of(made_up_run(tmp_path / "gsiirl", "gsiirl", ENDS, regret=0.0123, **BEST))
    assert gain_note(group, rivals_of(group)).endswith("GSIIRL misses 1.23 % (its regret).")


def test_marl_alone_has_nothing_to_be_compared_with(tmp_path: Path) -> None:
    assert said(group_of(made_up_run(tmp_path / "marl", "marl", [-6.3]))) == []


def test_a_correlation_without_failed_seeds_has_that_of_all_beside_it(tmp_path: Path) -> None:
    found = alone(tmp_path, [-4.6, -99.0], expert_reward_pearson=np.array([0.9, 0.5]))
    assert found[2].endswith("a correlation of 0.900 with the truth (1 is perfect; over all 2 seeds 0.700).")
