import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.games import Crossing, CrossingState
from gsiirl.types import Sides


def test_both_start_in_their_boxes():
    starts = jax.vmap(Crossing().reset)(jax.random.split(jax.random.key(0), 500)).positions
    for side, (left, right), (low, high) in (
        (starts.learner, (-0.25, 0.25), (-0.5, -0.4)),
        (starts.expert, (0.4, 0.5), (-0.25, 0.25)),
    ):
        x, y = np.asarray(side).T
        assert left <= x.min() < x.max() <= right
        assert low <= y.min() < y.max() <= high
        # The whole box is used.
        assert x.max() - x.min() > 0.9 * (right - left)
        assert y.max() - y.min() > 0.9 * (high - low)


def test_a_step_moves_each_side_by_a_tenth_of_its_action():
    state = CrossingState(Sides(jnp.array([0.1, 0.2]), jnp.array([-0.3, 0.4])))
    after = Crossing().step(state, Sides(jnp.array([1.0, -1.0]), jnp.array([0.5, 0.0]))).positions
    np.testing.assert_allclose(after.learner, [0.2, 0.1], rtol=1e-6)
    np.testing.assert_allclose(after.expert, [-0.25, 0.4], rtol=1e-6)


def test_both_sides_see_both_positions_their_own_first():
    state = CrossingState(Sides(jnp.array([0.1, 0.2]), jnp.array([-0.3, 0.4])))
    seen = Crossing().observe(state)
    np.testing.assert_allclose(seen.learner, [0.1, 0.2, -0.3, 0.4])
    np.testing.assert_allclose(seen.expert, [-0.3, 0.4, 0.1, 0.2])
