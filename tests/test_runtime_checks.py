"""Annotated types and shapes of the package are checked at run time, under test only."""

import jax.numpy as jnp
import pytest
from jaxtyping import TypeCheckError

from gsiirl.rewards import Linear, TabularFeatures
from gsiirl.types import Sides


def test_an_array_of_the_wrong_rank_is_refused():
    reward = Linear(TabularFeatures(table=jnp.ones((2, 3, 3, 1)), names=("feature",)), scale=1.0)
    with pytest.raises(TypeCheckError):
        reward.payoff(jnp.ones((1, 1)))


def test_an_array_of_the_wrong_type_is_refused():
    reward = Linear(TabularFeatures(table=jnp.ones((2, 3, 3, 1)), names=("feature",)), scale=1.0)
    with pytest.raises(TypeCheckError):
        reward(jnp.ones(1), jnp.asarray(0.5), Sides(jnp.asarray(0), jnp.asarray(0)))
