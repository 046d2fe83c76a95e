import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.equilibria.several_starts import best_of_starts


@pytest.mark.parametrize(("steps", "ends"), [(4, 4.0), (5, 5.0), (0, 0.0)])
def test_the_start_that_is_worth_most_halfway_takes_all_steps(steps: int, ends: float):
    # The second start is ahead at first, the third one after half of the steps, the first one would be at the end.
    speeds = jnp.array([1.0, 0.0, 0.5])
    worths = jnp.array([0.0, 3.0, 3.5])

    def climb(start, key, number):
        place, taken = start
        return place, taken + number

    def worth(start):
        place, taken = start
        return worths[place] + speeds[place] * taken

    key = jax.random.key(0)
    place, taken = best_of_starts((jnp.arange(3), jnp.zeros(3)), climb, worth, key, steps)
    expected = np.argmax(np.asarray(worths) + np.asarray(speeds) * (steps // 2))
    assert int(place) == expected == 2
    assert float(taken) == ends


def test_halves_of_the_search_draw_other_numbers():
    def climb(start, key, number):
        return jnp.concatenate([start[1:], jax.random.uniform(key, (1,))])

    first, second = best_of_starts(jnp.zeros((1, 2)), climb, lambda start: start[-1], jax.random.key(0), 2)
    assert first != second
