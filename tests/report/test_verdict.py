"""The sentences follow from the numbers."""

from pathlib import Path

import numpy as np
import pytest

from gsiirl.report.group import group_runs
from gsiirl.report.run import ReportedRun
from gsiirl.report.verdict import verdicts
from gsiirl.runs import RunFolder, summarise


def sentences(folder: Path, deployed: list[float], **metrics: float) -> list[str]:
    run = RunFolder.create(folder / "run", {"experiment": "security", "algorithm": "gsiirl"}, {"name": "g"})
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


def test_the_correlation_and_its_price_are_told(tmp_path: Path) -> None:
    found = sentences(tmp_path, [-4.6, -4.7, -4.5], expert_reward_pearson=0.9971, expert_trajectories=5000.0)
    assert found[1] == (
        "The attacker's reward as GSIIRL learned it correlates 0.997 with the true one (1 is perfect), "
        "after 5000 observed trajectories a seed."
    )
