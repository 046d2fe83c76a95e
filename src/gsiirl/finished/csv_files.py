"""A run as CSV files, which every program reads."""

from pathlib import Path

import polars

from gsiirl.runs import LearnedParameters, RunFolder
from gsiirl.runs.files.atomic import refuse_unwritable


def write_csv_files(run: RunFolder, out: Path) -> list[Path]:
    """Write what there is of the run; returns the files.

    * `metrics.csv`: a row a seed and iteration, a column a metric.
    * `learned.csv`: a row a seed, reward and weight: the weight in reward units, the interval if it has one.
    * `paths.csv`: a row a step of the sample episodes.

    Raises:
        InputError: the run is damaged, or `out` cannot be written.
    """
    tables = {"metrics": run.metrics(), "learned": _learned(run.load_learned()), "paths": run.paths()}
    written = []
    with refuse_unwritable("--out", out):
        for name, table in tables.items():
            if table is not None:
                table.write_csv(out / f"{name}.csv")
                written.append(out / f"{name}.csv")
    return written


def _learned(learned: LearnedParameters | None) -> polars.DataFrame | None:
    if learned is None:
        return None
    rows = [row for reward in learned.arrays for row in _rows(learned, reward)]
    # A reward without intervals comes before one that has them.
    return polars.DataFrame(rows, infer_schema_length=None)


def _rows(learned: LearnedParameters, reward: str) -> list[dict[str, object]]:
    intervals = learned.intervals.get(reward) or [None] * len(learned.seeds)
    return [
        {
            "seed": seed,
            "reward": reward,
            "weight_of": name,
            "weight": float(weight),
            "low": None if interval is None else interval.low[place],
            "high": None if interval is None else interval.high[place],
            "determined": None if interval is None else interval.determined[place],
        }
        for seed, of_seed, interval in zip(learned.seeds, learned.weights(reward), intervals, strict=True)
        for place, (name, weight) in enumerate(zip(learned.names[reward], of_seed, strict=True))
    ]
