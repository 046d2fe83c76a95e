"""What a run learned: parameters of rewards, with the names and the scale that make them readable."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gsiirl.errors import InputError
from gsiirl.runs.files.array_file import read_arrays, write_arrays
from gsiirl.runs.files.damage import START_AGAIN
from gsiirl.runs.files.json_file import read_versioned_json, versioned, write_json


@dataclass(frozen=True)
class LearnedParameters:
    """Learned parameters of every seed."""

    seeds: list[int]
    arrays: dict[str, np.ndarray]
    """Parameters in the unit ball, each of shape [seeds, features]."""
    scales: dict[str, float]
    """Reward units of a parameter of 1."""
    names: dict[str, list[str]]
    """Feature names, in the order of the parameters."""

    def weights(self, name: str) -> np.ndarray:
        """Weights in reward units, scale * parameter, of shape [seeds, features]."""
        return self.scales[name] * self.arrays[name]


def write_learned(
    folder: Path,
    arrays: Mapping[str, np.ndarray],
    scales: Mapping[str, float],
    names: Mapping[str, Sequence[str]],
    seeds: Sequence[int],
) -> None:
    """Write `learned.safetensors` and `learned.json`.

    Raises:
        ValueError: the three mappings name different parameters, or a shape is not [seeds, features].
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
    content = versioned({"seeds": [int(seed) for seed in seeds], "parameters": parameters})
    write_json(folder / "learned.json", content)


def read_learned(folder: Path) -> LearnedParameters | None:
    """What was learned, or None where nothing was (`marl`, or a run that has not ended).

    Raises:
        InputError: one of the two files is damaged, or they disagree.
    """
    path = folder / "learned.json"
    if not path.exists():
        return None
    description = read_versioned_json(path, START_AGAIN)
    arrays, _ = read_arrays(folder / "learned.safetensors", START_AGAIN)
    try:
        parameters = description["parameters"]
        learned = LearnedParameters(
            seeds=[int(seed) for seed in description["seeds"]],
            arrays={name: arrays[name] for name in parameters},
            scales={name: float(parameters[name]["scale"]) for name in parameters},
            names={name: list(parameters[name]["names"]) for name in parameters},
        )
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            str(path), f"is damaged or does not fit learned.safetensors ({error!r})", START_AGAIN
        ) from error
    for name, array in learned.arrays.items():
        if array.shape != (len(learned.seeds), len(learned.names[name])):
            raise InputError(str(path), f"{name} does not fit its array of shape {array.shape}", START_AGAIN)
    return learned
