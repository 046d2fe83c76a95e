"""Runs of which only the last iteration is made up, for tests of what is said of them."""

from pathlib import Path
from typing import Any

import numpy as np

from gsiirl.report.read.group import GameGroup, group_runs
from gsiirl.report.read.run import ReportedRun
from gsiirl.runs import RunFolder, summarise

REFERENCES = {"truth_return_learner": -6.3, "random_return_learner": -9.6}


def made_up_run(
    path: Path, algorithm: str, deployed: list[float], experiment: str = "security", first_seed: int = 0, **metrics: Any
) -> Path:
    """A run of one iteration that ends at `deployed`, one return a seed, and at other `metrics`."""
    game = {"name": "g", "variant": metrics.pop("variant", "")} | metrics.pop("game", {})
    config = {"experiment": experiment, "algorithm": algorithm, **metrics.pop("config", {})}
    run = RunFolder.create(path, config, game)
    ones = np.ones(len(deployed))
    columns = {"deployed_return_learner": np.array(deployed), **REFERENCES, **metrics}
    rows = {"seed": np.arange(first_seed, first_seed + len(deployed)), "iteration": np.zeros(len(deployed), int)}
    run.append_metrics(0, rows | {name: value * ones for name, value in columns.items()})
    run.write_summary(summarise(run.config, run.metrics(), completed=True))
    return run.path


def group_of(*paths: Path) -> GameGroup:
    """The one group that runs of one game make."""
    (group,) = group_runs([ReportedRun.read(path) for path in paths])
    return group
