import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.evaluation.transition_similarity import epic, pearson
from gsiirl.types import Sides, Transition


def sample(seed: int) -> Transition:
    values = np.random.default_rng(seed).normal(size=(4, 60)).astype(np.float32)
    return Transition(values[0], Sides(values[1], values[2]), values[3])


def first(seen: Transition) -> jax.Array:
    return seen.following + 0.5 * seen.actions.expert


def second(seen: Transition) -> jax.Array:
    return seen.following**2 - seen.actions.expert


@pytest.mark.parametrize("seed", range(3))
def test_pearson_is_that_of_numpy(seed: int) -> None:
    seen = sample(seed)
    expected = np.corrcoef(np.asarray(first(seen)), np.asarray(second(seen)))[0, 1]
    assert float(pearson(first, second, seen)) == pytest.approx(expected, abs=1e-5)


def test_scale_and_offset_change_nothing_a_sign_turns_it_and_a_constant_is_like_nothing() -> None:
    seen = sample(0)
    assert float(pearson(first, lambda one: 3.0 * first(one) - 7.0, seen)) == pytest.approx(1.0, abs=1e-5)
    assert float(pearson(first, lambda one: -first(one), seen)) == pytest.approx(-1.0, abs=1e-5)
    assert float(pearson(first, lambda one: 0.0 * first(one), seen)) == 0.0


def test_epic_is_0_for_the_same_1_for_the_opposite_and_between_as_the_distance_of_standard_scores() -> None:
    assert [float(epic(jnp.asarray(each))) for each in (1.0, -1.0)] == [0.0, 1.0]
    one, other = (np.asarray(each(sample(1)), float) for each in (first, second))
    one, other = ((each - each.mean()) / each.std() for each in (one, other))
    # Half the distance of the two rewards once both have mean 0 and variance 1.
    expected = 0.5 * np.sqrt(np.mean((one - other) ** 2))
    assert float(epic(pearson(first, second, sample(1)))) == pytest.approx(expected, abs=1e-5)
