"""The policies that a run ended with: weights of their networks, by name."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from gsiirl.program.presence import is_there
from gsiirl.runs.files.array_file import read_versioned_arrays, write_arrays
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.files.json_file import FORMAT_VERSION
from gsiirl.runs.learned import refuse_unsound
from gsiirl.runs.summary import Summary

DRAWS = "expert_reward.draws"
"""Name under which draws (K, m) from the posterior are kept, in units of the scale of `learned.json`."""


def write_policies(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write the weights, each of shape [seeds, ...], under names such as `learner.layers.0.weight`."""
    write_arrays(path, arrays, {"format_version": str(FORMAT_VERSION)})


def read_policies(path: Path, summary: Summary | None, carries: bool = False) -> dict[str, np.ndarray] | None:
    """The weights by name, or None where there are none (a run that has not ended).

    Raises:
        InputError: the file is damaged, of an unknown format, or not of the seeds of the summary.
    """
    if not is_there(path):
        return None
    arrays, _ = read_versioned_arrays(path, START_AGAIN, carries)
    if summary is not None:
        refuse_unsound(path, arrays, summary)
    return arrays
