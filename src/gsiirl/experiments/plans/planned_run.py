"""One run of a plan: its configuration, its folder, and how it is begun or gone on with."""

from pathlib import Path
from typing import NamedTuple

from gsiirl.experiments.config import ExperimentConfig
from gsiirl.program.progress import Told
from gsiirl.runs import RunFolder

RETRIES = 2
"""How often a run whose process ended is gone on with before it is given up."""


HERE = "here"
"""In place of a Ray cluster's address: one of this machine alone, which ends with the command."""


class PlannedRun(NamedTuple):
    """A configuration, and where its run is or will be."""

    folder: Path
    config: ExperimentConfig


def do(planned: PlannedRun, told: Told | None = None) -> None:
    """Begin a run, or go on with it; its progress is shown, or told to `told`."""
    from gsiirl.experiments import runner

    folder, config = planned
    if RunFolder.is_at(folder):
        runner.resume(folder, told)
    else:
        runner.run(config, folder, told)


def is_finished(folder: Path) -> bool:
    """Whether `folder` holds a run that has ended."""
    return RunFolder.is_at(folder) and RunFolder.open(folder).is_finished()
