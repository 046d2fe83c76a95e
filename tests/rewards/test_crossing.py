import jax
import jax.numpy as jnp
import numpy as np
import pytest

from gsiirl.games.crossing import CrossingState
from gsiirl.rewards import crossing as rewards
from gsiirl.types import Sides, Transition


def steps(number: int = 50) -> Transition:
    """Steps between unrelated states, so that it shows which of the two a reward looks at."""
    random = np.random.default_rng(0)

    def pairs() -> Sides[jax.Array]:
        return Sides(*jnp.asarray(random.uniform(-0.3, 0.3, (2, number, 2)), jnp.float32))

    return Transition(CrossingState(pairs()), pairs(), CrossingState(pairs()))


def oracle(name: str, robot: np.ndarray, human: np.ndarray, speed: np.ndarray) -> float:
    distance = np.linalg.norm(robot - human)
    collision, unease = np.exp(-0.5 * (distance / 0.1) ** 2), np.exp(-0.5 * (distance / 0.2) ** 2)
    return {
        "own_reward": -np.linalg.norm(robot - [0.0, 0.5]),
        "human_reward": -np.linalg.norm(human - [-0.5, 0.0]) - 5.0 * collision,
        "dependent_reward": -unease - 0.1 * np.exp(-0.5 * speed @ speed / 0.3**2) - 5.0 * collision,
    }[name]


@pytest.mark.parametrize("name", ["own_reward", "human_reward", "dependent_reward"])
def test_a_step_is_paid_by_the_places_after_it(name: str) -> None:
    sample = steps()
    found = jax.vmap(getattr(rewards, name))(sample)
    places, actions = jax.tree.map(np.asarray, (sample.following.positions, sample.actions))
    expected = [oracle(name, *each) for each in zip(places.learner, places.expert, actions.expert, strict=True)]
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_the_features_are_of_the_places_after_a_step() -> None:
    sample = steps(20)
    found = np.asarray(jax.vmap(rewards.HumanFeatures())(sample))
    places, actions = jax.tree.map(np.asarray, (sample.following.positions, sample.actions))
    axis = np.linspace(-0.7, 0.7, 5)
    for row, robot, human, action in zip(found, places.learner, places.expert, actions.expert, strict=True):
        distance = np.linalg.norm(robot - human)
        expected = [-np.hypot(np.linalg.norm(human - [x, y]), 0.25) for x in axis for y in axis]
        expected += [-40.0 * np.exp(-0.5 * (distance / width) ** 2) for width in (0.1, 0.2, 0.4)]
        np.testing.assert_allclose(row, [*expected, -action @ action], rtol=1e-4, atol=1e-5)
