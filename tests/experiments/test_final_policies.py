"""Which networks each algorithm's ending keeps; nothing is compiled."""

from typing import Any

import jax
import pytest

from gsiirl.experiments.deception.config import DeceptionConfig
from gsiirl.experiments.deception.problem import prepare

pytestmark = pytest.mark.usefixtures("optax_promotion")

SIZES = {"learner": (21, 4), "expert": (9, 2), "response": (9, 2)}
HIDDEN = 3


@pytest.mark.parametrize(
    "algorithm", [*(pytest.param(name, marks=pytest.mark.slow) for name in ("gsiirl", "ma-irl")), "marl"]
)
def test_the_ending_keeps_every_network(algorithm):
    with jax.enable_x64(False):
        small: dict[str, Any] = {
            "horizon": 2,
            "batch": 2,
            "trajectories": 2,
            "evaluation_episodes": 2,
            "hidden": HIDDEN,
        }
        algorithm = prepare(DeceptionConfig(algorithm=algorithm, **small).resolved()).algorithm
        key = jax.eval_shape(lambda: jax.random.key(0))
        ending = jax.eval_shape(lambda key: algorithm.finish(algorithm.init(key), key), key)
    expected = {}
    for name, (inputs, outputs) in SIZES.items():
        for layer, (before, after) in enumerate([(inputs, HIDDEN), (HIDDEN, HIDDEN), (HIDDEN, outputs)]):
            expected[f"{name}.layers.{layer}.weight"] = (after, before)
            expected[f"{name}.layers.{layer}.bias"] = (after,)
    assert {name: array.shape for name, array in ending.policies.items()} == expected
    assert {array.dtype.name for array in ending.policies.values()} == {"float32"}
