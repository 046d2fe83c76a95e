import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.baselines.replay import Experience, Replay
from gsiirl.types import Sides, Transition

ROUNDS, ENVIRONMENTS = 3, 4


def experience(round_: int) -> Experience:
    """Round 2 of environment 1 is 21 in every number of it."""
    numbers = 10.0 * round_ + jnp.arange(ENVIRONMENTS, dtype=jnp.float32)
    places = jnp.broadcast_to(numbers[:, None], (ENVIRONMENTS, 2))
    transition = Transition(places, Sides(places, numbers[:, None]), places)
    return Experience(transition, numbers.astype(jnp.int32))


def after(rounds: int) -> Replay:
    replay = Replay.create(jax.tree.map(lambda leaf: leaf[0], experience(0)), ROUNDS, ENVIRONMENTS)
    for round_ in range(1, rounds + 1):
        replay = replay.add(experience(round_))
    return replay


def test_only_what_was_stored_is_drawn_and_all_of_it():
    for rounds in (1, 2, 3):
        drawn = after(rounds).sample(jax.random.key(0), 500)
        stored = {10 * round_ + one for round_ in range(1, rounds + 1) for one in range(ENVIRONMENTS)}
        assert {int(time) for time in drawn.time} == stored


def test_the_oldest_is_overwritten_first():
    for rounds in (4, 5, 7):
        drawn = after(rounds).sample(jax.random.key(0), 500)
        newest = {10 * round_ + one for round_ in range(rounds - ROUNDS + 1, rounds + 1) for one in range(ENVIRONMENTS)}
        assert {int(time) for time in drawn.time} == newest


def test_a_step_stays_together():
    drawn = after(5).sample(jax.random.key(1), 100)
    transition = drawn.transition
    for leaf in (transition.state, transition.actions.learner, transition.actions.expert, transition.following):
        np.testing.assert_array_equal(leaf, np.broadcast_to(np.asarray(drawn.time)[:, None], leaf.shape))


def test_every_step_is_equally_likely():
    drawn = after(4).sample(jax.random.key(2), 12_000)
    _, counts = np.unique(np.asarray(drawn.time), return_counts=True)
    assert counts.shape == (ROUNDS * ENVIRONMENTS,)
    # Four standard deviations.
    np.testing.assert_allclose(counts, 1000, atol=125)


def test_precisions_are_kept():
    dtypes = {str(leaf.dtype) for leaf in jax.tree.leaves(after(1))}
    assert dtypes == {"float32", "int32"}
