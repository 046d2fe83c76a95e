"""Players read the state and the time from what they observe."""

import numpy as np
import pytest

from gsiirl.adapters.numpy_policy import NumpyPolicy
from gsiirl.errors import InputError
from gsiirl.pettingzoo.players import NetworkPlayer, TablePlayer

NODES = np.array([[0, 1, 0], [1, 1, 0], [1, 1, 1]], np.float32)


def certain(steps: int) -> TablePlayer:
    """Picks action t · 3 + s."""
    actions = np.arange(3 * steps).reshape(steps, 3)
    return TablePlayer(np.eye(3 * steps)[actions], NODES)


@pytest.mark.parametrize("steps", [1, 7, 10_000 // 100])
def test_a_table_is_read_at_the_state_and_time_observed(steps: int):
    player, random = certain(steps), np.random.default_rng(0)
    for time in range(steps):
        for state, nodes in enumerate(NODES):
            seen = np.append(nodes, np.float32(time) / np.float32(steps))
            assert player(seen, random) == 3 * time + state


def test_actions_are_drawn_as_often_as_the_table_says():
    chances = np.array([0.0, 0.1, 0.6, 0.0, 0.3])
    player = TablePlayer(chances[None, None], NODES[:1])
    random = np.random.default_rng(0)
    drawn = [player(np.append(NODES[0], 0.0), random) for _ in range(4000)]
    np.testing.assert_allclose(np.bincount(drawn, minlength=5) / 4000, chances, atol=0.03)


@pytest.mark.parametrize("seen", [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 1.0]])
def test_an_observation_that_the_policy_does_not_know_is_refused(seen: list[float]):
    with pytest.raises(InputError, match=r"observation: .* is none that the policy knows"):
        certain(4)(np.array(seen, np.float32), np.random.default_rng(0))


def test_a_network_is_given_what_is_observed_and_then_the_time():
    layer = (np.eye(3, dtype=np.float32), np.zeros(3, np.float32))
    player = NetworkPlayer(NumpyPolicy((layer, layer, layer)))
    action = player(np.array([0.5, -0.5, 0.25], np.float32), np.random.default_rng(0))
    assert action.dtype == np.float32
    np.testing.assert_allclose(action, np.tanh(np.tanh(np.tanh([0.5, -0.5, 0.25]))), atol=1e-6)
