"""Policies of continuous games: small smooth networks."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from gsiirl.types import AnyArray, Number

_FIRST_ACTIONS = 0.1
"""Scale of the last layer at the start: first actions are small, where the outer tanh is not saturated."""


@jax.custom_vjp
def _tanh(value: Array) -> Array:
    """tanh, whose derivative 1 − tanh² is computed from its value on the way back.

    JAX would keep both for every step of an episode: twice the memory to go through, and a sixth of an ascent's time.
    """
    return jnp.tanh(value)


def _tanh_and_itself(value: Array) -> tuple[Array, Array]:
    result = jnp.tanh(value)
    return result, result


def _tanh_back(result: Array, change: Array) -> tuple[Array]:
    return (change * (1.0 - result * result),)


_tanh.defvjp(_tanh_and_itself, _tanh_back)


class PolicyNetwork(eqx.Module):
    """π(o, t/T) = tanh(network of two hidden tanh layers) ∈ [−1, 1]^A, deterministic.

    Time is an input because the horizon is finite: what is best to do depends on what is left.
    """

    layers: tuple[eqx.nn.Linear, ...]

    @classmethod
    def create(cls, observation_size: int, action_size: int, hidden: int, key: PRNGKeyArray) -> "PolicyNetwork":
        """Random weights; one input more than is observed, for the time."""
        sizes = (observation_size + 1, hidden, hidden, action_size)
        keys = jax.random.split(key, len(sizes) - 1)
        layers = [
            eqx.nn.Linear(inputs, outputs, dtype=jnp.float32, key=one)
            for inputs, outputs, one in zip(sizes[:-1], sizes[1:], keys, strict=True)
        ]
        layers[-1] = jax.tree.map(lambda leaf: _FIRST_ACTIONS * leaf, layers[-1])
        return cls(tuple(layers))

    def __call__(self, observation: Float[AnyArray, " o"], time: Number) -> Float[Array, " A"]:
        return _tanh(self.intention(observation, time))

    def intention(self, observation: Float[AnyArray, " o"], time: Number) -> Float[Array, " A"]:
        """The action before the outer tanh."""
        value = jnp.concatenate([observation, jnp.asarray(time, observation.dtype)[None]])
        for layer in self.layers[:-1]:
            value = _tanh(layer(value))
        return self.layers[-1](value)


class NoisyPolicy(eqx.Module):
    """tanh(intention + noise_t): a policy whose hand shakes; `noise` (T, A) is that of one episode."""

    policy: PolicyNetwork
    noise: Float[Array, "T A"]

    def __call__(self, observation: Float[Array, " o"], time: Float[Array, ""]) -> Float[Array, " A"]:
        steps = self.noise.shape[0]
        step = jnp.round(time * steps).astype(jnp.int32)
        return _tanh(self.policy.intention(observation, time) + self.noise[step])
