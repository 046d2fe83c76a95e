"""A learned policy in plain numpy, for simulators that step one state at a time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

LAYERS = 3


@dataclass(frozen=True)
class NumpyPolicy:
    """π(o, t/T) of `gsiirl.equilibria.policy_network`: a tanh after each of its three layers."""

    layers: tuple[tuple[np.ndarray, np.ndarray], ...]
    """Weight and bias of each layer."""

    def __post_init__(self) -> None:
        if any(weight.ndim != 2 or bias.shape != weight.shape[:1] for weight, bias in self.layers):
            raise ValueError("a layer's weight is no matrix, or does not fit its bias")

    @classmethod
    def of(cls, weights: Mapping[str, np.ndarray], name: str, seed: int) -> Self:
        """The network of that name, of the seed at that place along the leading axis.

        Raises:
            KeyError: there is no network of that name.
            IndexError: there are fewer seeds.
            ValueError: a layer is none.
        """
        return cls(
            tuple(
                (weights[f"{name}.layers.{layer}.weight"][seed], weights[f"{name}.layers.{layer}.bias"][seed])
                for layer in range(LAYERS)
            )
        )

    def __call__(self, observation: np.ndarray, time: float) -> np.ndarray:
        """The action within ±1 along each axis, for what is observed and t/T."""
        value = np.append(observation, np.float32(time))
        for weight, bias in self.layers:
            value = np.tanh(weight @ value + bias)
        return value
