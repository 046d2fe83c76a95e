"""Warnings, and what is told besides returns."""

from pathlib import Path

import numpy as np
from report.made_up import group_of, made_up_run

from gsiirl.report.page.notes import notes, warnings

ENDS = [-4.6, -4.7, -4.5]


def test_rates_have_a_verdict_beside_those_of_marl_deployed(tmp_path: Path) -> None:
    gsiirl = made_up_run(
        tmp_path / "gsiirl",
        "gsiirl",
        ENDS,
        "crossing",
        collision_rate=np.array([0.01, 0.03, 0.011]),
        goal_rate_robot=1.0,
        goal_rate_human=np.array([0.9, 0.91, 0.92]),
        human_goal_error=0.04,
    )
    # The rates of its pair as it was trained are not what is compared.
    marl = made_up_run(
        tmp_path / "marl",
        "marl",
        ENDS,
        "crossing",
        collision_rate=np.array([0.012, 0.01, 0.014]),
        truth_collision_rate=0.5,
        goal_rate_robot=0.0,
        goal_rate_human=np.array([0.9, 0.91, 0.92]),
    )
    assert notes(group_of(gsiirl, marl)) == [
        "In the encounters of GSIIRL's robot (in brackets MARL's, deployed too), the two collide in 1.7 % (1.2 %: "
        "cannot tell with 3 seeds), the robot reaches its goal in 100.0 % (0.0 %: more often) and the human reaches "
        "its own in 91.0 % (91.0 %: the same).",
        "GSIIRL places the human's goal 0.040 ± 0.000 from where it is.",
    ]


def test_two_seeds_suffice_where_nothing_varies(tmp_path: Path) -> None:
    runs = [
        made_up_run(tmp_path / algorithm, algorithm, ENDS[:2], "crossing", goal_rate_robot=rate)
        for algorithm, rate in (("gsiirl", 0.0), ("marl", 1.0))
    ]
    assert notes(group_of(*runs))[0].endswith("the robot reaches its goal in 0.0 % (100.0 %: less often).")


def test_without_marl_rates_stand_alone(tmp_path: Path) -> None:
    group = group_of(made_up_run(tmp_path / "gsiirl", "gsiirl", ENDS, "crossing", collision_rate=0.012))
    assert notes(group) == ["In the encounters of GSIIRL's robot, the two collide in 1.2 %."]


def test_which_landmark_it_was_is_counted_by_seeds(tmp_path: Path) -> None:
    preference = np.array([0.5, -0.1, 0.7])
    group = group_of(made_up_run(tmp_path / "gsiirl", "gsiirl", ENDS, "deception", target_preference=preference))
    assert notes(group)[0].endswith("GSIIRL found out in 2 of 3 seeds.")


def test_what_sampling_alone_explains_of_the_misfit_is_told(tmp_path: Path) -> None:
    group = group_of(made_up_run(tmp_path / "gsiirl", "gsiirl", ENDS, feature_gap=0.08, feature_gap_noise=0.05))
    assert notes(group)[0].endswith("by 0.080 in its features; sampling alone would make 0.050.")


def test_failed_seeds_are_named_with_the_rule(tmp_path: Path) -> None:
    (warning,) = warnings(group_of(made_up_run(tmp_path / "gsiirl", "gsiirl", [-4.6, -99.0, np.nan, -4.5])))
    assert warning.startswith("2 of 4 seeds of GSIIRL failed (seeds 1, 2); a seed has failed when")
    assert "decided by the true return, which no learner sees" in warning
    assert warning.endswith(
        "leave them out: 2 of 4 remain. Means over all 4 seeds stand beside them, and verdicts count all seeds."
    )


def test_rates_and_errors_count_failed_seeds_as_their_verdicts_do(tmp_path: Path) -> None:
    # The second seed ends below random play, and its robot never arrives.
    arrivals, errors = np.array([1.0, 0.0]), np.array([0.4, 0.2])
    ours = made_up_run(
        tmp_path / "gsiirl",
        "gsiirl",
        [-4.6, -99.0],
        "crossing",
        goal_rate_robot=arrivals,
        human_goal_error=errors,
    )
    theirs = made_up_run(tmp_path / "marl", "marl", [-4.6, -4.7], "crossing", goal_rate_robot=1.0)
    assert notes(group_of(ours, theirs)) == [
        "In the encounters of GSIIRL's robot, failed seeds included (in brackets MARL's, deployed too), the robot "
        "reaches its goal in 50.0 % (100.0 %: cannot tell with 2 seeds).",
        "GSIIRL places the human's goal 0.300 ± 0.141 from where it is; failed seeds included.",
    ]


def test_a_failed_seed_that_did_not_find_the_landmark_counts(tmp_path: Path) -> None:
    preference = np.array([0.5, -0.1])
    run = made_up_run(tmp_path / "gsiirl", "gsiirl", [-4.6, -99.0], "deception", target_preference=preference)
    assert notes(group_of(run))[0].endswith("GSIIRL found out in 1 of 2 seeds.")
