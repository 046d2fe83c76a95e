"""The sentences follow from the numbers."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gsiirl.report.page.verdicts import verdicts
from gsiirl.report.read.group import group_runs
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs import RunFolder, summarise


def sentences(folder: Path, deployed: list[float], experiment: str = "security", **metrics: Any) -> list[str]:
    run = RunFolder.create(folder / "run", {"experiment": experiment, "algorithm": "gsiirl"}, {"name": "g"})
    ones = np.ones(len(deployed))
    columns = {"truth_return_learner": -6.34, "random_return_learner": -9.1, **metrics}
    run.append_metrics(
        0,
        {
            "seed": np.arange(len(deployed)),
            "iteration": np.full(len(deployed), 50),
            "deployed_return_learner": np.array(deployed),
            **{name: value * ones for name, value in columns.items()},
        },
    )
    run.write_summary(summarise(run.config, run.metrics(), completed=True))
    (group,) = group_runs([ReportedRun.read(run.path)])
    return verdicts(group)


@pytest.mark.parametrize(
    ("deployed", "verdict"),
    [
        ([-4.6, -4.7, -4.5], "it does better than MARL."),
        ([-7.6, -7.7, -7.5], "it does worse than MARL."),
        ([-6.0, -6.9, -6.2], "it does neither better nor worse than MARL (which lies within the 95 % interval)."),
    ],
)
def test_better_or_worse_is_decided_by_the_interval(tmp_path: Path, deployed: list[float], verdict: str) -> None:
    (sentence,) = sentences(tmp_path, deployed)
    assert sentence.endswith(verdict)
    assert (
        "MARL, which was given both rewards, at \N{MINUS SIGN}6.34; "
        "a defender that plays at random, at \N{MINUS SIGN}9.10" in sentence
    )


@pytest.mark.parametrize(
    ("met", "verdict"), [([7.4, 7.5, 7.7], "those of GSIIRL do better than that."), ([9.0, 9.0, 9.0], None)]
)
def test_marls_own_learner_is_told_as_the_real_expert_meets_it(
    tmp_path: Path, met: list[float], verdict: str | None
) -> None:
    runs = []
    for algorithm, earned in (("gsiirl", [7.9, 8.0, 8.1]), ("marl", met)):
        run = RunFolder.create(tmp_path / algorithm, {"experiment": "deception", "algorithm": algorithm}, {"name": "g"})
        columns = {
            "deployed_return_learner": earned,
            "truth_return_learner": [9.0] * 3,
            "random_return_learner": [0.0] * 3,
        }
        values = {name: np.array(value) for name, value in columns.items()}
        run.append_metrics(0, {"seed": np.arange(3), "iteration": np.zeros(3, int), **values})
        run.write_summary(summarise(run.config, run.metrics(), completed=True))
        runs.append(ReportedRun.read(run.path))
    (group,) = group_runs(runs)
    found = [sentence for sentence in verdicts(group) if "that learned beside them" in sentence]
    if verdict is None:
        assert found == []
    else:
        (sentence,) = found
        assert "Once the real adversary has answered them too, they end at 7.53 \N{PLUS-MINUS SIGN} 0.15" in sentence
        assert sentence.endswith(verdict)


def test_the_correlation_and_its_price_are_told(tmp_path: Path) -> None:
    found = sentences(tmp_path, [-4.6, -4.7, -4.5], expert_reward_pearson=0.9971, expert_trajectories=5000.0)
    assert found[1] == (
        "The attacker's reward as GSIIRL learned it correlates 0.997 with the true one (1 is perfect), "
        "after 5000 observed trajectories a seed."
    )


def test_better_or_worse_is_decided_seed_by_seed(tmp_path: Path) -> None:
    # The returns spread more than they differ from MARL's, which spread with them.
    truth = np.array([-5.0, -7.0, -9.0])
    (sentence,) = sentences(tmp_path, [-4.5, -6.4, -8.5], truth_return_learner=truth, random_return_learner=-20.0)
    assert sentence.endswith("it does better than MARL.")


def test_several_good_agents_are_spoken_of_as_such(tmp_path: Path) -> None:
    found = sentences(
        tmp_path, [-4.6, -4.7, -4.5], experiment="deception", target_preference=np.array([0.5, -0.1, 0.7])
    )
    assert found[0].startswith("The good agents that learned by interacting (GSIIRL) end at")
    assert "good agents that have learned nothing, at" in found[0]
    assert found[0].endswith("they do better than MARL.")
    assert found[1].endswith("GSIIRL found out in 2 of 3 seeds.")


def test_collisions_and_arrivals_are_told_beside_marls(tmp_path: Path) -> None:
    found = sentences(
        tmp_path,
        [-4.6, -4.7, -4.5],
        experiment="crossing",
        collision_rate=0.012,
        truth_collision_rate=0.01,
        goal_rate_robot=1.0,
        human_goal_error=0.04,
    )
    assert found[1] == (
        "In the encounters of the robot of GSIIRL, the two collide in 1.2 % (MARL 1.0 %), the robot reaches its goal "
        "in 100.0 %."
    )
    assert found[2] == "GSIIRL places the human's goal 0.040 ± 0.000 from where it is."


def test_what_sampling_alone_explains_of_the_misfit_is_told(tmp_path: Path) -> None:
    found = sentences(tmp_path, [-4.6, -4.7, -4.5], feature_gap=0.08, feature_gap_noise=0.05)
    assert found[1].endswith("by 0.080 in its features; sampling alone would make 0.050.")
