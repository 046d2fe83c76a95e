import jax
import jax.numpy as jnp
import numpy as np

from gsiirl.irl.memory import Memory, Played


def remembered(key, number: int, capacity: int):
    """Indices held after interactions 1, …, `number`."""

    def one(memory, index):
        value = jnp.asarray(index, float)
        policy = jnp.full((1, 1, 2), value)
        return memory.remember(jax.random.fold_in(key, index), Played(policy, value[None])), None

    empty = Memory.empty(capacity, Played(jnp.full((1, 1, 2), 0.5), jnp.zeros(1)))
    memory, _ = jax.lax.scan(one, empty, jnp.arange(1, number + 1))
    return memory


def test_the_newest_is_always_held_and_nothing_is_held_twice():
    for number in (1, 2, 3, 4, 9):
        memory = remembered(jax.random.key(0), number, 4)
        held = memory.kept.demonstrated[:, 0][memory.filled].tolist()
        assert held[0] == number
        assert len(set(held)) == len(held) == min(number, 4)
        np.testing.assert_array_equal(memory.kept.learner_policy[:, 0, 0, 0][memory.filled], held)


def test_earlier_interactions_are_held_equally_often():
    runs, number, capacity = 4000, 9, 4
    memories = jax.vmap(lambda key: remembered(key, number, capacity))(jax.random.split(jax.random.key(1), runs))
    counts = np.bincount(np.asarray(memories.kept.demonstrated[:, 1:, 0]).astype(int).ravel(), minlength=number + 1)
    expected = runs * (capacity - 1) / (number - 1)
    assert counts[number] == 0
    assert np.all(np.abs(counts[1:number] - expected) <= 5 * np.sqrt(expected))


def test_a_memory_of_one_holds_the_newest_alone():
    memory = remembered(jax.random.key(0), 5, 1)
    assert memory.kept.demonstrated[:, 0].tolist() == [5.0]
