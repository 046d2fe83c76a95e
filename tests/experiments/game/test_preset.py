"""Special cases of a game from a file, and the games that they come with."""

from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from experiments.game.test_game import ARRAYS, FUNCTION, written

from gsiirl.errors import InputError
from gsiirl.experiments.game.config import GameConfig
from gsiirl.experiments.game.examples import EXAMPLES
from gsiirl.experiments.game.file import read_game
from gsiirl.experiments.game.preset import Preset

SHARES: dict[Preset, float] = {"cooperative": 1.0, "competitive": -1.0}


@pytest.mark.parametrize("preset", SHARES)
def test_a_preset_sets_what_the_learner_earns_whatever_the_file_says(tmp_path: Path, preset: Preset):
    own = read_game(written(tmp_path), True, preset)
    np.testing.assert_array_equal(own.problem.dependent_value.dense(), SHARES[preset] * ARRAYS["expert_reward"])
    assert not np.any(own.problem.own_reward.dense())
    np.testing.assert_array_equal(own.expert_reward, ARRAYS["expert_reward"])
    assert (own.problem.discount, own.problem.temperature) == (0.9, 0.4)


def test_a_preset_goes_with_a_function_too(tmp_path: Path):
    path = tmp_path / "mine.py"
    path.write_text(FUNCTION)
    own = read_game(f"{path}:duel", True, "competitive")
    np.testing.assert_array_equal(own.problem.dependent_value.dense(), [[[-1.0, 0.0], [0.0, -1.0]]])


def test_a_decision_process_is_a_classic_game_with_an_idle_learner(tmp_path: Path):
    random = np.random.default_rng(0)
    alone: dict[str, Any] = {
        "transitions": random.dirichlet(np.ones(2), (2, 3)),
        "expert_reward": random.uniform(-1, 1, (2, 3)),
        "own_reward": None,
        "dependent_value": None,
    }
    problem = read_game(written(tmp_path, **alone), True, "classic").problem
    assert (problem.game.number_of_actions.learner, problem.game.number_of_actions.expert) == (1, 3)
    follows = problem.game.continuation(jnp.asarray([0.0, 1.0])).dense()
    np.testing.assert_allclose(follows[:, 0], alone["transitions"][..., 1], rtol=1e-12)
    assert not np.any(problem.dependent_value.dense())
    features = read_game(written(tmp_path, **alone, expert_features=np.ones((2, 3, 4))), True, "classic").problem
    assert len(features.expert_names) == 4
    with pytest.raises(InputError, match="transitions: has shape"):
        read_game(written(tmp_path, **alone), True, "cooperative")


@pytest.mark.parametrize("name", ["transitions", "expert_reward"])
def test_what_the_learner_does_must_not_matter_in_a_classic_game(tmp_path: Path, name: str):
    array = ARRAYS[name]
    same = {each: np.repeat(ARRAYS[each][:, :1], 2, axis=1) for each in ("transitions", "expert_reward")}
    assert read_game(written(tmp_path, **same), True, "classic").problem.game.number_of_actions.learner == 2
    with pytest.raises(InputError, match=rf"^{name} of mine: depends on what the learner does; give P\[s, a, s'\]"):
        read_game(written(tmp_path, **(same | {name: array})), True, "classic")


def test_a_preset_needs_no_file():
    assert GameConfig(preset="classic").resolved().file == ""
    with pytest.raises(InputError, match=r"FILE: is missing; give FILE\.npz, or FILE\.py:NAME, or --preset"):
        GameConfig().resolved()
    names = {preset: read_game("", True, preset).name for preset in EXAMPLES}
    assert names == {"cooperative": "maze", "competitive": "soccer", "classic": "walk"}


def test_the_maze_lets_the_expert_through_the_door_that_is_held_open():
    follows = EXAMPLES["cooperative"]()["transitions"]
    right = 4
    for row in range(3):
        before, behind = 4 * row + 1, 4 * row + 2
        passed = [follows[before, door, right, behind] for door in range(3)]
        assert passed == [float(door == row) for door in range(3)]


def test_soccer_is_the_same_game_for_both_sides():
    """Mirrored, with the sides exchanged, it is itself; and who scores ends it."""
    game = EXAMPLES["competitive"]()
    follows, reward = game["transitions"], game["expert_reward"]
    cells = [(row, column) for row in range(2) for column in range(3)]
    states = [(at, other, ball) for at in cells for other in cells if at != other for ball in (0, 1)]

    def mirrored(cell: tuple[int, int]) -> tuple[int, int]:
        return cell[0], 2 - cell[1]

    image = [states.index((mirrored(other), mirrored(at), 1 - ball)) for at, other, ball in states] + [len(states)]
    action = [0, 1, 2, 4, 3]
    np.testing.assert_allclose(follows.sum(-1), 1.0, rtol=1e-15)
    swapped = follows[image][:, action][:, :, action][..., image].swapaxes(1, 2)
    np.testing.assert_array_equal(follows, swapped)
    np.testing.assert_array_equal(reward, -reward[image][:, action][:, :, action].swapaxes(1, 2))
    # From the left edge the expert scores with the ball, unless the other is there first.
    alone = states.index(((0, 2), (1, 0), 1))
    assert (reward[alone, 0, 3], follows[alone, 0, 3, -1]) == (1.0, 1.0)
    assert reward[states.index(((0, 2), (1, 0), 0)), 0, 3] == 0.0
