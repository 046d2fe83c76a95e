"""Episodes of a user's own expert are refused where the game cannot have made them."""

import itertools
from dataclasses import replace
from typing import Any

import jax
import numpy as np
import pytest

from gsiirl.demonstrations.finite import checked, doubts, evidence
from gsiirl.errors import InputError
from gsiirl.games import TabularGame
from gsiirl.games.attack_graph import AttackGraph
from gsiirl.games.base import AbstractTabularGame
from gsiirl.types import Sides, Trajectories
from tests.helpers import small_network

MOVE = np.zeros((3, 2, 2, 3))
for state in range(3):
    MOVE[state, :, 0, state] = 1.0
    MOVE[state, :, 1, (state + 1) % 3] = 1.0
"""The expert's action 1 goes round, action 0 stays."""
PADDED = (
    np.broadcast_to([[0, 1, 1], [0, 2, 0], [1, 0, 0]], (2, 2, 3, 3)).transpose(2, 0, 1, 3),
    np.broadcast_to([0.5, 0.5, 0.0], (3, 2, 2, 3)),
)
"""Successors twice, and some of probability 0."""
CERTAIN = replace(small_network(), success_probability=np.ones(len(small_network().edge_names)))


def game(**settings: Any) -> TabularGame:
    return TabularGame.from_arrays(MOVE, initial=[0.5, 0.5, 0.0], horizon=3, **settings)


def shown(states: list[int], expert: list[int], mask: tuple[bool, ...] = (True, True, True)) -> Trajectories:
    """One episode, after a sound one."""
    return Trajectories.from_arrays([[0, 1, 2], states], np.zeros((2, 3), int), [[1, 1, 1], expert], [[True] * 3, mask])


def test_what_the_game_can_do_is_accepted() -> None:
    assert checked(shown([1, 1, 2], [0, 1, 0]), 2, game()).mask.all()


@pytest.mark.parametrize(
    ("episode", "said"),
    [
        (shown([2, 2, 2], [0, 0, 0]), "episode 1 begins in state 2, where the game never begins"),
        (
            shown([0, 2, 2], [1, 0, 0]),
            r"episode 1 goes at step 0 from state 0 to state 2 by learner's action 0 and expert's action 1, which",
        ),
        (shown([0, 0, 0], [0, 1, 0]), "episode 1 goes at step 1 from state 0 to state 0"),
        (shown([0, 1, 2], [1, 1, 1], (False, True, True)), "episode 1 has no first step"),
        (shown([0, 1, 2], [1, 1, 1], (True, False, True)), "episode 1 goes on after a step that is masked"),
    ],
)
def test_what_it_cannot_do_is_refused_with_its_place(episode: Trajectories, said: str) -> None:
    with pytest.raises(InputError, match=said):
        checked(episode, 2, game())


def test_after_an_episodes_end_anything_may_stand() -> None:
    assert checked(shown([0, 2, 9], [0, 9, 9], (True, False, False)), 2, game()).mask.sum() == 4
    ends_in_1 = game(terminal=[1])
    assert checked(shown([0, 1, 0], [1, 0, 0]), 2, ends_in_1).mask.sum() == 2
    with pytest.raises(InputError, match="episode 1 goes at step 0 from state 0 to state 1"):
        checked(shown([0, 1, 0], [0, 0, 0]), 2, ends_in_1)


def test_an_episode_that_begins_at_its_end_needs_no_step() -> None:
    assert checked(shown([1, 0, 0], [0, 0, 0], (False, False, False)), 2, game(terminal=[1])).mask.sum() == 1
    with pytest.raises(InputError, match="episode 1 has no first step"):
        checked(shown([2, 0, 0], [0, 0, 0], (False, False, False)), 2, game(terminal=[2]))


@pytest.mark.parametrize(
    "of",
    [
        game(),
        TabularGame.from_arrays((MOVE.argmax(-1)[..., None], np.ones((3, 2, 2, 1))), initial=[1, 0, 0], horizon=2),
        TabularGame.from_arrays(PADDED, initial=[1, 0, 0], horizon=2, terminal=[2]),
        AttackGraph.create(small_network(), horizon=3, learner_no_op=True, expert_no_op=True),
        AttackGraph.create(small_network(), horizon=3),
        AttackGraph.create(CERTAIN, horizon=3),
    ],
    ids=["dense", "sparse", "sparse with padding", "network with no-ops", "network", "attacks that never fail"],
)
def test_what_is_possible_is_where_mass_flows(of: AbstractTabularGame) -> None:
    states, (learners, experts) = of.number_of_states, (of.number_of_actions.learner, of.number_of_actions.expert)
    for learner in range(learners):
        for expert in range(experts):
            pure = [np.zeros((states, number)) for number in (learners, experts)]
            pure[0][:, learner], pure[1][:, expert] = 1.0, 1.0
            policies = Sides(*map(jax.numpy.asarray, pure))
            flow = np.asarray(jax.vmap(lambda start: of.advance(start, policies))(np.eye(states)))  # noqa: B023
            before, after = (each.ravel() for each in np.indices((states, states)))
            actions = Sides(np.full(before.size, learner), np.full(before.size, expert))
            np.testing.assert_array_equal(of.possible(before, actions, after), flow[before, after] > 0)


# --- Whose actions are the learner's ---

TURNS = TabularGame.from_arrays(np.ones((2, 3, 1, 2)) / 2, initial=[0.5, 0.5], horizon=2)
"""Two states, three actions of the learner."""


def policy_of(seed: int, sharp: float) -> np.ndarray:
    return np.asarray(jax.nn.softmax(sharp * np.random.default_rng(seed).normal(size=(2, 2, 3))), float)


def played_by(policy: np.ndarray, episodes: int, seed: int = 0) -> Trajectories:
    random = np.random.default_rng(seed)
    states = random.integers(2, size=(episodes, 2))
    actions = [
        [random.choice(3, p=policy[t, state] / policy[t, state].sum()) for t, state in enumerate(row)] for row in states
    ]
    return Trajectories.from_arrays(states, actions, np.zeros((episodes, 2), int))


@pytest.mark.parametrize("states", [[[0, 0], [0, 1]], [[1, 1], [1, 1]]])
def test_the_evidence_against_a_policy_is_an_e_value(states: list[list[int]]) -> None:
    policy = policy_of(0, 2.0)
    total = 0.0
    for actions in itertools.product(range(3), repeat=4):
        chosen = np.reshape(actions, (2, 2))
        chance = np.prod([[policy[t, states[d][t], chosen[d, t]] for t in range(2)] for d in range(2)])
        seen = Trajectories.from_arrays(states, chosen, np.zeros((2, 2), int))
        total += chance * np.exp(evidence(seen, policy, TURNS))
    assert total == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("sharp", [0.0, 1.0, 5.0])
def test_episodes_of_the_policy_itself_are_not_doubted(sharp: float) -> None:
    for seed in range(20):
        policy = policy_of(seed, sharp)
        assert not doubts(played_by(policy, 100, seed), policy, TURNS)


@pytest.mark.parametrize(("asked", "played"), [(0.0, 5.0), (5.0, 0.0), (5.0, 5.0)])
def test_episodes_of_another_policy_are_doubted(asked: float, played: float) -> None:
    said = doubts(played_by(policy_of(1, played), 100), policy_of(2, asked), TURNS)
    assert said["learner"].startswith("demonstrations.actions.learner are not drawn from the policy")


def test_an_action_that_the_policy_never_takes_is_doubted() -> None:
    never = np.broadcast_to([1.0, 0.0, 0.0], (2, 2, 3))
    assert doubts(Trajectories.from_arrays([[0, 0]], [[0, 1]], [[0, 0]]), never, TURNS)
    assert not doubts(Trajectories.from_arrays([[0, 0]], [[0, 1]], [[0, 0]], [[True, False]]), never, TURNS)
    assert not doubts(Trajectories.from_arrays([[0, 0]], [[0, 1]], [[0, 0]], [[False, False]]), never, TURNS)


def test_of_forbidden_actions_nothing_is_expected() -> None:
    allowed = [[True, True, False], [True, False, False]]
    game = TabularGame.from_arrays(np.ones((2, 3, 1, 2)) / 2, initial=[0.5, 0.5], horizon=2, learner_actions=allowed)
    policy = np.broadcast_to([[0.5, 0.5, 0.0], [1.0, 0.0, 0.0]], (2, 2, 3))
    total = 0.0
    for first, second in itertools.product(range(2), repeat=2):
        seen = Trajectories.from_arrays([[0, 1], [0, 1]], [[first, 0], [second, 0]], np.zeros((2, 2), int))
        total += 0.25 * np.exp(evidence(seen, policy, game))
    assert total == pytest.approx(1.0, abs=1e-9)
