"""Linear rewards of tabular games."""

import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.rewards import IndicatorFeatures
from gsiirl.types import Sides

SHAPE = (2, 3, 4)


def test_every_entry_of_a_table_has_one_weight() -> None:
    features = IndicatorFeatures(shape=SHAPE, names=("an entry",) * 24)
    assert not jax.tree.leaves(features)
    states, learner, expert = jnp.asarray(np.indices(SHAPE).reshape(3, -1))
    places = features.place(states, Sides(learner, expert))
    np.testing.assert_array_equal(places, np.arange(24))
    table = features.payoff(jnp.asarray(np.arange(24.0))).dense()
    np.testing.assert_array_equal(table[states, learner, expert], places)
    np.testing.assert_array_equal(features(states[17], Sides(learner[17], expert[17])), np.eye(24)[17])
