"""Policy networks as named arrays, as a run folder keeps them."""

from collections.abc import Mapping

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from gsiirl.equilibria.policy_network import PolicyNetwork

PARTS = ("weight", "bias")


def weights_of(**policies: PolicyNetwork) -> dict[str, Array]:
    """The weights of policies by name; `learner=policy` gives `learner.layers.0.weight` and so on."""
    return {
        f"{name}.layers.{index}.{part}": getattr(layer, part)
        for name, policy in policies.items()
        for index, layer in enumerate(policy.layers)
        for part in PARTS
    }


def policy_of(name: str, weights: Mapping[str, np.ndarray]) -> PolicyNetwork:
    """The policy of this name; as many along a leading axis as the weights have."""
    number = sum(key.startswith(f"{name}.layers.") for key in weights) // len(PARTS)
    layers = [f"{name}.layers.{index}" for index in range(number)]
    return network_of([(weights[f"{layer}.weight"], weights[f"{layer}.bias"]) for layer in layers])


def network_of(layers: list[tuple[np.ndarray, np.ndarray]]) -> PolicyNetwork:
    """The network with these weights (..., outputs, inputs) and biases (..., outputs)."""
    made: list[eqx.nn.Linear] = []
    for arrays in layers:
        outputs, inputs = arrays[0].shape[-2:]
        empty = eqx.nn.Linear(inputs, outputs, dtype=jnp.float32, key=jax.random.key(0))
        leaves = tuple(jnp.asarray(each, jnp.float32) for each in arrays)
        made.append(eqx.tree_at(lambda layer: (layer.weight, layer.bias), empty, leaves))
    return PolicyNetwork(tuple(made))
