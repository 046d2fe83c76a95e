"""A run's metrics for TensorBoard."""

from pathlib import Path

import polars

from gsiirl.errors import InputError
from gsiirl.program.command import installing
from gsiirl.runs import RunFolder
from gsiirl.runs.files.atomic import refuse_unwritable


def write_event_files(run: RunFolder, out: Path) -> list[Path]:
    """Write a folder `seed-N` for each seed, with a curve for every metric over iterations; returns the folders.

    What is measured at the end alone is one point there. `tensorboard --logdir OUT` shows them.

    Raises:
        InputError: tensorboardX is not installed, the run is damaged, or `out` cannot be written.
    """
    try:
        from tensorboardX import SummaryWriter
    except ImportError:
        mend = f"install it with `{installing('tensorboardx>=2.6')}`"
        raise InputError("--to", "tensorboard needs tensorboardX, which is not installed", mend) from None
    metrics, written = run.metrics(), []
    names = [name for name in metrics.columns if name not in ("seed", "iteration")]
    with refuse_unwritable("--out", out):
        for rows in metrics.partition_by("seed", maintain_order=True):
            folder = out / f"seed-{rows['seed'][0]}"
            written.append(folder)
            with SummaryWriter(str(folder)) as writer:
                for name in names:
                    for iteration, value in _measured(rows, name):
                        writer.add_scalar(name, value, iteration)
    return written


def _measured(rows: polars.DataFrame, name: str) -> list[tuple[int, float]]:
    """Iterations and values of a metric, where it was measured."""
    kept = rows.filter(polars.col(name).is_finite())
    return list(zip(kept["iteration"].to_list(), kept[name].to_list(), strict=True))
