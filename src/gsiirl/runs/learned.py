"""What a run learned: parameters of rewards, with the names and the scale that make them readable."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from gsiirl.errors import InputError
from gsiirl.program.presence import is_there
from gsiirl.runs.files.array_file import read_arrays, write_arrays
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.files.json_file import as_typed, read_versioned_json, versioned, write_json
from gsiirl.runs.files.numbers import is_sound
from gsiirl.runs.summary import Summary

DETERMINED = 0.5
"""Standard deviation of the posterior, as a share of the prior's, up to which a weight or a direction is determined."""
LEVEL = 0.9
"""Probability with which the intervals of `learned.json` hold the weights."""


@dataclass(frozen=True)
class Interval:
    """Between which values the weights of one seed lie with probability `level`, in reward units."""

    level: float
    low: list[float]
    high: list[float]
    determined: list[bool]
    """Whether the interactions determined each weight: its deviation is at most half of the prior's."""


def intervals_of(draws: np.ndarray, priors: np.ndarray) -> list[Interval | None]:
    """Intervals at `LEVEL` of every seed's weights, from draws of their posterior [seeds, draws, features].

    Both are in reward units; `priors` [seeds] are standard deviations. None where draws are no numbers.
    """
    return [_interval(of_seed, prior) for of_seed, prior in zip(draws, priors, strict=True)]


def _interval(draws: np.ndarray, prior: float) -> Interval | None:
    if not np.isfinite(draws).all():
        return None
    low, high = quantiles(draws, LEVEL)
    return Interval(LEVEL, low.tolist(), high.tolist(), (share_of_prior(draws, prior) <= DETERMINED).tolist())


def quantiles(draws: np.ndarray, level: float, axis: int = 0) -> np.ndarray:
    """Quantiles (1 − level)/2 and (1 + level)/2 of the draws along `axis`, which a first axis of 2 replaces."""
    return np.quantile(draws, [0.5 - level / 2, 0.5 + level / 2], axis=axis)


def share_of_prior(draws: np.ndarray, prior: np.ndarray | float) -> np.ndarray:
    """Standard deviation of draws [..., draws, features] as a share of the prior's [...]."""
    return draws.std(axis=-2, ddof=1) / np.asarray(prior)[..., None]


@dataclass(frozen=True)
class LearnedParameters:
    """Learned parameters of every seed."""

    seeds: list[int]
    arrays: dict[str, np.ndarray]
    """Parameters in units of `scales`, each of shape [seeds, features].

    Of a commitment to a policy they have no bound; of all others a vector is at most 1 long.
    """
    scales: dict[str, float]
    """Reward units of a parameter of 1."""
    names: dict[str, list[str]]
    """Feature names, in the order of the parameters."""
    intervals: dict[str, list[Interval | None]]
    """Of what has a posterior: an interval a seed, None where the seed has none."""

    def weights(self, name: str) -> np.ndarray:
        """Weights in reward units, scale * parameter, of shape [seeds, features]."""
        return self.scales[name] * self.arrays[name]


def write_learned(
    folder: Path,
    arrays: Mapping[str, np.ndarray],
    scales: Mapping[str, float],
    names: Mapping[str, Sequence[str]],
    seeds: Sequence[int],
    intervals: Mapping[str, Sequence[Interval | None]],
) -> None:
    """Write `learned.safetensors` and `learned.json`.

    Raises:
        ValueError: the first three mappings name different parameters, or a shape is not [seeds, features].
    """
    if not arrays.keys() == scales.keys() == names.keys():
        raise ValueError(f"arrays, scales and names differ: {sorted(arrays)}, {sorted(scales)}, {sorted(names)}")
    for name, array in arrays.items():
        if array.shape != (len(seeds), len(names[name])):
            raise ValueError(f"{name} has shape {array.shape}, not {(len(seeds), len(names[name]))}")
    write_arrays(folder / "learned.safetensors", arrays)
    parameters = {
        name: {"shape": list(arrays[name].shape), "scale": float(scales[name]), "names": list(names[name])}
        for name in arrays
    }
    for name, each in intervals.items():
        parameters[name]["intervals"] = [None if one is None else asdict(one) for one in each]
    content = versioned({"seeds": [int(seed) for seed in seeds], "parameters": parameters})
    write_json(folder / "learned.json", content)


def read_learned(folder: Path, summary: Summary | None, carries: bool = False) -> LearnedParameters | None:
    """What was learned, or None where nothing was (`marl`, or a run that has not ended).

    Raises:
        InputError: one of the two files is damaged, they disagree, or hold no numbers for a seed that did not fail.
    """
    path, arrays_path = folder / "learned.json", folder / "learned.safetensors"
    if not is_there(path):
        return None
    described = as_typed(_Described, read_versioned_json(path, START_AGAIN, carries), path, START_AGAIN)
    arrays, _ = read_arrays(arrays_path, START_AGAIN, carries)
    if arrays.keys() != described.parameters.keys():
        raise InputError(str(path), "is damaged: it does not name the arrays of learned.safetensors", START_AGAIN)
    for name, each in described.parameters.items():
        shape = (len(described.seeds), len(each.names))
        if arrays[name].shape != shape or each.shape != list(shape) or arrays[name].dtype.kind != "f":
            raise InputError(str(path), f"{name} does not fit its array of shape {arrays[name].shape}", START_AGAIN)
        known = [one for one in each.intervals or [] if one is not None]
        if each.intervals is not None and len(each.intervals) != shape[0]:
            raise InputError(str(path), f"is damaged: {name} has intervals for other seeds", START_AGAIN)
        if any({len(one.low), len(one.high), len(one.determined)} != {shape[1]} for one in known):
            raise InputError(str(path), f"is damaged: {name} has intervals for other weights", START_AGAIN)
    if summary is not None:
        if summary.seeds != described.seeds:
            raise InputError(str(path), "is damaged: it is not of the seeds of summary.json", START_AGAIN)
        refuse_unsound(arrays_path, arrays, summary)
    return LearnedParameters(
        described.seeds,
        arrays,
        {name: each.scale for name, each in described.parameters.items()},
        {name: each.names for name, each in described.parameters.items()},
        {name: each.intervals for name, each in described.parameters.items() if each.intervals is not None},
    )


def refuse_unsound(path: Path, arrays: Mapping[str, np.ndarray], summary: Summary) -> None:
    """See that the arrays [seeds, ...] of `path` hold numbers for every seed that did not fail.

    Raises:
        InputError: one holds none, or is not of all seeds.
    """
    kept = [place for place, seed in enumerate(summary.seeds) if seed in summary.kept_seeds]
    for name, array in arrays.items():
        if array.ndim == 0 or len(array) != len(summary.seeds):
            raise InputError(str(path), "is damaged: it is not of all seeds", START_AGAIN)
        if array.dtype.kind != "f" or not is_sound(array[kept]).all():
            raise InputError(str(path), f"is damaged: {name} holds what is no number", START_AGAIN)


@dataclass(frozen=True)
class _Parameter:
    shape: list[int]
    scale: float
    names: list[str]
    intervals: list[Interval | None] | None = None


@dataclass(frozen=True)
class _Described:
    """The content of `learned.json`."""

    seeds: list[int]
    parameters: dict[str, _Parameter]
