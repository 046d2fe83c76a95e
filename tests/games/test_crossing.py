import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.games import Crossing, CrossingState
from gsiirl.games.rollout import play
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


def test_a_policy_is_told_what_share_of_the_episode_is_over():
    nothing = jnp.zeros(2, jnp.float32)
    policies = Sides(lambda seen, time: nothing + time, lambda seen, time: nothing)
    told = play(Crossing(horizon=4), policies, CrossingState(Sides(nothing, nothing)))
    np.testing.assert_array_equal(told.actions.learner[:, 0], [0.0, 0.25, 0.5, 0.75])
    np.testing.assert_allclose(told.following.positions.learner[:, 0], [0.0, 0.025, 0.075, 0.15], atol=1e-7)


def test_an_episode_goes_on_from_what_each_step_led_to():
    game = Crossing(horizon=6)
    ways = Sides(lambda seen, time: 0.3 + 0.1 * seen[:2], lambda seen, time: -0.2 * seen[2:] + time)
    start = game.reset(jax.random.key(1))
    episode = play(game, ways, start)
    state = start
    for step in range(6):
        at, to, actions = (
            jax.tree.map(lambda leaf, step=step: leaf[step], part)
            for part in (episode.state.positions, episode.following.positions, episode.actions)
        )
        np.testing.assert_array_equal(at.learner, state.positions.learner)
        np.testing.assert_array_equal(at.expert, state.positions.expert)
        state = game.step(state, actions)
        np.testing.assert_allclose(to.learner, state.positions.learner, rtol=1e-6)
        np.testing.assert_allclose(to.expert, state.positions.expert, rtol=1e-6)
