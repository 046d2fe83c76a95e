import jax.numpy as jnp
import numpy as np

from gsiirl.irl.estimated_policy import estimated_policy


def test_counts_and_one_visit_before_them():
    prior = jnp.full((2, 3, 2), 0.5).at[1, 2].set(jnp.array([0.9, 0.1]))
    states = jnp.array([[0, 1], [0, 1], [0, 0]])
    actions = jnp.array([[1, 0], [1, 0], [0, 1]])
    estimated = np.asarray(estimated_policy(states, actions, prior))
    np.testing.assert_allclose(estimated[0, 0], [1.5 / 4, 2.5 / 4])
    np.testing.assert_allclose(estimated[1, 1], [2.5 / 3, 0.5 / 3])
    np.testing.assert_allclose(estimated[1, 0], [0.5 / 2, 1.5 / 2])
    # Nothing was seen there.
    np.testing.assert_allclose(estimated[1, 2], [0.9, 0.1])
    np.testing.assert_allclose(estimated.sum(-1), 1.0)
